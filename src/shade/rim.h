// SPDX-License-Identifier: Apache-2.0
// The outer rim of the valid ground as polygons of long straight sides.
#pragma once

#include <vector>

#include "math/types.h"
#include "shade/overview.h"

namespace terray {

/// A closed polygon in mip-0 lattice places, the ground at the right hand of its sides (i to the
/// right, j down); the last corner is joined to the first.
using RimLoop = std::vector<Vec2>;

/// The outer rims of an overview's ground. Holes inside are not rims, nor are narrow ones at the
/// border. Where ground ends at holes and not only at the raster's border, the rim runs a cell or
/// two of the overview within it, so that straight sides replace the steps of cells and still have
/// ground above them.
std::vector<RimLoop> outerRims(const Overview& view);

}  // namespace terray
