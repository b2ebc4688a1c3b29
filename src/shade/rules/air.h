// SPDX-License-Identifier: Apache-2.0
// Air: the sky's gradient and the haze that distance adds.
#pragma once

#include <cmath>

#include "shade/rules/colour.h"

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
    if (above >= 0) return glm::mix(air.zenith, air.horizon, std::exp(-above * 3.2f));
    return glm::mix(air.below, air.horizon, std::exp(above * 3.2f));
}

/// Share of the light that comes through `distance` metres of air.
inline float clearness(const Air& air, float distance) {
    const float through = distance - air.start;
    return through > 0 ? std::exp(-air.extinction * through) : 1.0f;
}

inline Rgb throughAir(const Air& air, const Rgb& colour, float distance) {
    const float clear = clearness(air, distance);
    const Rgb haze = glm::mix(air.horizon, air.near, clear);
    return colour * clear + haze * (1.0f - clear);
}

}  // namespace terray::rules
