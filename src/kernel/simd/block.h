// SPDX-License-Identifier: Apache-2.0
// The state of up to 64 rays in flight, one array per quantity, so that any SIMD width can step
// them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "kernel/layout/layout.h"
#include "kernel/ray_batch.h"

namespace terray::simd {

constexpr int kBlockRays = kBatchRays;

enum LaneState : int32_t {
    kLaneDone = 0,
    kLaneDirectory = 1,  ///< stands in a square of the directory
    kLaneTile = 2,       ///< stands in a tile: in its pyramid, or at a cell when level == mip
};

enum LaneResult : int32_t { kResultMiss = 0, kResultHit = 1, kResultUncertain = 2 };

/// Float rays are relative to an anchor: the mip-0 cell in which the clipped ray begins, and a
/// height in the middle of the terrain. t counts from the clipped begin.
struct alignas(64) RayBlock {
    // the ray
    int32_t anchorX[kBlockRays], anchorY[kBlockRays];
    float fx[kBlockRays], fy[kBlockRays];  ///< place in the anchor cell
    float dx[kBlockRays], dy[kBlockRays], inverseDx[kBlockRays], inverseDy[kBlockRays];
    float z[kBlockRays], dz[kBlockRays], bend[kBlockRays], vertex[kBlockRays];
    float tEnd[kBlockRays];
    float error0[kBlockRays],
        error1[kBlockRays];  ///< height error of the float ray: error0 + error1 t
    float anywhere0[kBlockRays],
        anywhere1[kBlockRays];  ///< the same with the lattice error on the steepest ground
    float shift1[kBlockRays];   ///< lattice error: kShift0 + shift1 t, mip-0 cells
    // where it stands
    float t[kBlockRays];
    int32_t x[kBlockRays], y[kBlockRays];  ///< mip-0 cell
    int32_t level[kBlockRays];             ///< block of 2^level mip-0 cells a side
    int32_t state[kBlockRays], result[kBlockRays], side[kBlockRays], steps[kBlockRays];
    int32_t below[kBlockRays];  ///< not 0: it was under the sheet somewhere
    int32_t
        entryLevel[kBlockRays];  ///< level at which the next tile is entered, kEnterAtTop once used
    // the tile it stands in
    int32_t slot[kBlockRays], mip[kBlockRays];
    int32_t boundsOffset[kBlockRays],
        postsOffset[kBlockRays];                        ///< bytes from the middle of the pool
    float boundsZ[kBlockRays], boundsStep[kBlockRays];  ///< relative to the anchor height
    float postsZ[kBlockRays], postsStep[kBlockRays];
    float tileDelta[kBlockRays];
};

constexpr int32_t kEnterAtTop = 63;

/// Lattice error near the origin, in cells: rounding of the fraction and of the cell's own edges.
constexpr float kShift0 = 2.4e-7f;
/// Relative error allowed for a float expression of a few operations (about 16 roundings).
constexpr float kFloatError = 4.8e-7f;
/// A decoded 16-bit post is rounded to half an ulp of its height; lanes, which work relative to an
/// anchor, do not round there.
inline float decodingError(const TerrainCut& cut) {
    return cut.format == 0 ? 0x1.2p-24f * std::max(std::fabs(cut.minZ), std::fabs(cut.maxZ)) : 0.0f;
}

}  // namespace terray::simd
