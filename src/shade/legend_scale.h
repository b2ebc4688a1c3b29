// SPDX-License-Identifier: Apache-2.0
// What a legend shows: the colours of a shading from bottom to top, and round labels along them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "image/canvas.h"
#include "shade/shade.h"

namespace terray {

/// A label beside the colour bar.
struct LegendTick {
    double position = 0;  ///< 0 at the bottom, 1 at the top
    std::string label;
};

struct LegendScale {
    std::string title;
    std::vector<LegendTick> ticks;
    std::function<Ink(double)> colour;  ///< of a position 0..1
};

/// 1, 2 or 5 times a power of ten: the largest not above, the smallest not below `value` (> 0).
double roundDown125(double value);
double roundUp125(double value);

/// Nothing for shadings whose colours stand for no number, and for tints without a ramp.
std::optional<LegendScale> legendScale(Shading shading, const TerrainInfo& info,
                                       const RayFrame& rays, const HeightRamp* ramp);

}  // namespace terray
