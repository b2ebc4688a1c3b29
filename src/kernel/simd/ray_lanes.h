// SPDX-License-Identifier: Apache-2.0
// The double-precision ends of a block's way: placing rays before the float traversal, and fixing
// each hit's distance after it. Compiled once per SIMD target, like the traversal.
#pragma once

#include <cstdint>

#include "kernel/simd/block.h"

namespace terray::simd {

/// The cells in which lanes have certain hits, and what double precision makes of them.
struct alignas(64) HitLanes {
    int32_t mip[kBlockRays];
    double cellX[kBlockRays], cellY[kBlockRays];  ///< in cells of the lane's mip
    double h00[kBlockRays], h10[kBlockRays], h01[kBlockRays], h11[kBlockRays];
    double t[kBlockRays];  ///< out: distance; NaN: double precision sees no root in this cell
    float u[kBlockRays], v[kBlockRays];
    int32_t fromBelow[kBlockRays];
};

/// Clips the rays to the true rectangle and to below the highest thing drawn, and places the float
/// rays of the block at their begin: in the directory, one below the root. Lanes without an
/// interval are done.
/// `level`: block size at which to begin, kEnterAtTop without a head start.
void placeRays(const TerrainCut& cut, RayBatch& rays, RayBlock& block, int count, int level);

/// First root of each lane's cell: of its quadratic, or of its two triangles (`surface`).
void finishHits(const RayBatch& rays, HitLanes& hits, int count, SurfaceKind surface);

}  // namespace terray::simd
