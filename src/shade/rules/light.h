// SPDX-License-Identifier: Apache-2.0
// What falls on a piece of ground: warm sun, cool sky, light thrown back by the ground around.
#pragma once

#include <glm/geometric.hpp>

#include "shade/rules/colour.h"

namespace terray::rules {

/// Light of a frame. Level ground in full sun under an open sky receives about 1.
struct Light {
    Rgb sun{0.0f};     ///< on a surface that faces the sun
    Rgb sky{0.0f};     ///< on level ground that sees the whole sky
    Rgb bounce{0.0f};  ///< thrown back by the ground where the sky is hidden
};

/// Open share of the sky with fine relief that the sky-light field does not resolve: tilted ground
/// (`up` = the normal's z) sees less of the sky.
inline float openShare(float openSky, float up) { return openSky * (0.60f + 0.40f * up); }

/// Share of the sun on ground that it reaches, `facing` = max(0, N.L). A hollow also loses part of
/// the sun's bright surroundings: the softness of hand-made relief.
inline float sunShare(float facing, float openSky) { return facing * (0.55f + 0.45f * openSky); }

/// Light of the sky, and of sunlit ground that walls and deep slopes look at instead.
inline Rgb shadeLight(const Light& light, float open) {
    return light.sky * open + light.bounce * (1.0f - open);
}

/// `lit` 0..1, `openSky` 0..1.
inline Rgb lightOn(const Light& light, float facing, float lit, float openSky, float up) {
    return light.sun * (lit * sunShare(facing, openSky)) +
           shadeLight(light, openShare(openSky, up));
}

/// Grey relief under several lights, weighted as aspects need them (after Mark, USGS OFR 92-422):
/// four suns, 30 degrees high, from 225, 270, 315 and 360 degrees. 0..1, level ground 0.5.
inline float multiHillshade(const glm::vec3& n) {
    constexpr float kDiagonal = 0.70710678f, kCos = 0.8660254f, kSin = 0.5f;
    const glm::vec3 suns[4] = {{-kDiagonal * kCos, -kDiagonal * kCos, kSin},
                               {-kCos, 0.0f, kSin},
                               {-kDiagonal * kCos, kDiagonal * kCos, kSin},
                               {0.0f, kCos, kSin}};
    const float weights[4] = {0.18f, 0.24f, 0.34f, 0.24f};
    float sum = 0;
    for (int k = 0; k < 4; ++k) sum += weights[k] * std::max(0.0f, glm::dot(n, suns[k]));
    return sum;
}

}  // namespace terray::rules
