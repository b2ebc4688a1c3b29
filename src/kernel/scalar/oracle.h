// SPDX-License-Identifier: Apache-2.0
// The oracle: the simplest exact loops in double precision, cell by cell, no acceleration. It
// judges every other kernel and shares nothing with them but the layout.
#pragma once

#include <limits>

#include "kernel/layout/layout.h"
#include "kernel/scalar/block_ranges.h"

namespace terray::oracle {

/// Decoded height of post (i, j) of a tile, 0..512; NaN for a hole.
double post(const TerrainCut& cut, uint32_t slot, int i, int j);

/// First hit by walking every cell of the drawn tiles along the ray. `t` in double beside the Hit.
/// Where the page on the surface leaves a choice: an edge between cells belongs to the cell being
/// left; a ray running along an edge belongs to the cell of larger index; a ray that starts on the
/// sheet hits at tMin, from above. Constant surface: u < 0.5 exactly when the hit lies in the left
/// half of its cell (walls included: the half being entered), and so for v.
struct ExactHit {
    Hit hit{};
    double t = std::numeric_limits<double>::infinity();
};
/// With ranges of blocks, blocks that the ray clears are passed in one step: the same hit, sooner.
ExactHit firstHit(const TerrainCut& cut, const Ray& ray, const BlockRanges* ranges = nullptr);

/// True if the ray leaving `hit` meets the surface again at t > 0 (rules of kernel/trace.h). The
/// place is the ray's x, y clamped to the hit's cell (its quadrant for the constant surface); the
/// ray's z only counts for hits on strips and walls, elsewhere it starts exactly on the sheet.
/// Running along the sheet, or along the strip or wall that was hit, is occluded (N.L = 0).
bool occluded(const TerrainCut& cut, const Hit& hit, const Ray& ray,
              const BlockRanges* ranges = nullptr);

}  // namespace terray::oracle
