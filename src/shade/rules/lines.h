// SPDX-License-Identifier: Apache-2.0
// Anti-aliased lines on the ground: contours and the edges of cells, of a width in pixels.
#pragma once

#include <algorithm>
#include <cmath>

namespace terray::rules {

inline float smoothStep(float from, float to, float v) {
    const float perUnit = 1.0f / (to - from);  // of constants, mostly
    const float x = std::clamp((v - from) * perUnit, 0.0f, 1.0f);
    return x * x * (3.0f - 2.0f * x);
}

/// Cover of a line `distance` pixels away.
inline float lineCover(float distance, float halfWidth) {
    return std::clamp(halfWidth + 0.5f - distance, 0.0f, 1.0f);
}

/// Cover of the lines at whole numbers of `v`, which changes by `perPixel` a pixel: fades out where
/// lines would be denser than about 3 pixels, and where the ground is too flat to tell.
inline float isoCover(float v, float perPixel, float halfWidth) {
    const float flat = smoothStep(1e-5f, 4e-5f, perPixel);
    const float dense = 1.0f - smoothStep(0.20f, 0.40f, perPixel);
    if (flat <= 0 || dense <= 0) return 0;
    const float away = std::abs(v - std::round(v));
    return flat * dense * lineCover(away / perPixel, halfWidth);
}

/// Contour lines every `interval`, each fifth an index line, heavier. Returns cover 0..1.
inline float contourCover(float height, float heightPerPixel, float interval) {
    const float plain = isoCover(height / interval, heightPerPixel / interval, 0.35f);
    const float index =
        isoCover(height / (5.0f * interval), heightPerPixel / (5.0f * interval), 0.75f);
    return std::max(0.55f * plain, 0.75f * index);
}

}  // namespace terray::rules
