// SPDX-License-Identifier: Apache-2.0
// The built-in ramps: their stops and how they spread over the heights.
#pragma once

#include <span>
#include <string_view>

namespace terray {

/// Position on the ramp 0..1, 8-bit sRGB, and how far steep ground leans to rock grey.
struct RampStop {
    float at;
    float r, g, b;
    float rock;
};

struct BuiltinRamp {
    std::string_view name, line;
    std::span<const RampStop> land, sea;
    float quantiles;    ///< share of the position taken from the heights' distribution; rest linear
    bool reservesSnow;  ///< low relief does not reach the ramp's cold end
    bool zeroIsSea;     ///< below 0 is sea whatever the survey says
};

/// The default first.
std::span<const BuiltinRamp> builtinRamps();
const BuiltinRamp* findBuiltinRamp(std::string_view name);

}  // namespace terray
