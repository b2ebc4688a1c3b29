// SPDX-License-Identifier: Apache-2.0
// Air: the sky's gradient and the haze that distance adds.
#pragma once

#include "shade/rules/colour.h"
#include "shade/rules/exp.h"

namespace terray::rules {

struct Air {
    Rgb horizon{0.8f};      ///< pale, where the sheet ends
    Rgb zenith{0.3f};       ///< deeper, above
    Rgb below{0.8f};        ///< under the horizon where the sheet has ended
    Rgb near{0.6f};         ///< what thin haze adds: bluer than the horizon
    float horizonSine = 0;  ///< sine of the elevation at which the gradient starts
    float extinction = 0;   ///< per metre
    float start = 0;        ///< metres of clear air before the haze begins
};

/// Colour of the sky along a unit direction with vertical component `sine`.
inline Rgb skyColour(const Air& air, float sine) {
    const float above = sine - air.horizonSine;
    const float near = expOf(-std::abs(above) * 3.2f);
    const Rgb far = glm::mix(air.below, air.zenith, above >= 0 ? 1.0f : 0.0f);
    return glm::mix(far, air.horizon, near);
}

/// Share of the light that comes through `distance` metres of air.
inline float clearness(const Air& air, float distance) {
    return expOf(-air.extinction * std::max(distance - air.start, 0.0f));
}

/// What the air itself adds, where a share `clear` of the light comes through.
inline Rgb hazeLight(const Air& air, float clear) {
    return glm::mix(air.horizon, air.near, clear) * (1.0f - clear);
}

inline Rgb throughAir(const Air& air, const Rgb& colour, float distance) {
    const float clear = clearness(air, distance);
    return colour * clear + hazeLight(air, clear);
}

}  // namespace terray::rules
