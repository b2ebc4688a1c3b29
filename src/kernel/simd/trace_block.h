// SPDX-License-Identifier: Apache-2.0
// The float traversal of a block of rays, compiled once per SIMD target and chosen at run time.
#pragma once

#include <string>
#include <vector>

#include "kernel/simd/block.h"

namespace terray::simd {

/// Steps the first `count` rays of the block until all are done: each lane's result is a miss, a
/// hit for certain in cell (x, y) of its tile, or uncertain. Lanes start in the state that the
/// block names.
void traceBlock(const TerrainCut& cut, RayBlock& block, int count);

}  // namespace terray::simd
