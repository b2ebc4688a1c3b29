// SPDX-License-Identifier: Apache-2.0
// Colour as numbers: linear light and sRGB, and the soft shoulder between scene and display.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>

namespace terray::rules {

using Rgb = glm::vec3;  ///< linear light, sRGB primaries

/// sRGB transfer curve (IEC 61966-2-1), both ways; 0..1.
inline float linearFromSrgb(float v) {
    return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}
inline float srgbFromLinear(float v) {
    return v <= 0.0031308f ? v * 12.92f : 1.055f * std::pow(v, 1.0f / 2.4f) - 0.055f;
}

inline float luminance(const Rgb& c) { return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b; }

/// Scene-linear above this is bent towards 1; below it passes unchanged.
constexpr float kShoulder = 0.50f;
/// The scene value that displays as full white within half an 8-bit code.
constexpr float kWhite = kShoulder + (1.0f - kShoulder) * 3.4f;

/// Soft shoulder: identity, then tanh with the same slope; never clips, never crushes.
inline float displayFromScene(float v) {
    if (v <= kShoulder) return std::max(v, 0.0f);
    const float room = 1.0f - kShoulder;
    return kShoulder + room * std::tanh((v - kShoulder) / room);
}
inline float sceneFromDisplay(float v) {
    if (v <= kShoulder) return std::max(v, 0.0f);
    const float room = 1.0f - kShoulder;
    const float x = std::min((v - kShoulder) / room, 0.9977f);
    return kShoulder + room * std::atanh(x);
}

/// 8-bit sRGB code to the scene value that displays as it.
inline float sceneFromCode(float code) { return sceneFromDisplay(linearFromSrgb(code / 255.0f)); }
inline Rgb sceneFromCodes(float r, float g, float b) {
    return {sceneFromCode(r), sceneFromCode(g), sceneFromCode(b)};
}

}  // namespace terray::rules
