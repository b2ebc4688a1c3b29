// SPDX-License-Identifier: Apache-2.0
// How the bounds of blocks of 64 x 64 cells come about: the rules that in-memory terrains and bake
// share. Pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "math/affine.h"
#include "tile/terrain_info.h"

namespace terray {

/// Slopes, cell ranges and holes of one row of a tile's blocks: cells [0, cellsX) x [0, cellsY),
/// cellsX <= 512, cellsY <= 64; posts are (cellsX + 1) x (cellsY + 1) of that mip.
void measureSteps(const float* posts, int64_t stride, int cellsX, int cellsY,
                  const Affine2& worldFromLattice, int mip, std::span<BlockBounds> blocks);

/// Heights of a block as its tile's pyramid has them: outward-rounded codes, or none.
void setHeights(BlockBounds& block, int mip, bool isEmpty, float minZ, float maxZ);

/// The largest of worst[first .. last], as SurfaceComparer returns them; `last` may lie beyond.
float largestError(std::span<const float> worst, int first, int last);

/// What an error of a block must be raised by for what rounding may hide, `shift` mips apart.
float withRounding(float error, const BlockBounds& block, int shift);

/// What a block of `mip` takes over from one of the four blocks of the next finer mip in it: flags,
/// cell ranges; for mip 1 also its error to mip 0, which is mip 0's error to mip 1.
void inheritFromFiner(BlockBounds& block, const BlockBounds& finer, int mip);

/// The ground distance by which rims of holes may stand elsewhere than at mip 0; after all four
/// finer blocks have been inherited from. mip >= 1.
void setCoverage(BlockBounds& block, const Affine2& worldFromLattice, int mip);

}  // namespace terray
