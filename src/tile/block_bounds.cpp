// SPDX-License-Identifier: Apache-2.0
// Bounds of blocks: slopes, errors with their rounding, and what passes from mip to mip.
#include "tile/block_bounds.h"

#include <algorithm>
#include <cmath>

#include "tile/mips.h"

namespace terray {

void measureSteps(const float* posts, int64_t stride, int cellsX, int cellsY,
                  const Affine2& worldFromLattice, int mip, std::span<BlockBounds> blocks) {
    for (int x = 0; x * kBlockCells < cellsX; ++x) {
        const int cells = std::min(kBlockCells, cellsX - x * kBlockCells);
        const CellSteps steps =
            measureCells(posts + static_cast<ptrdiff_t>(x) * kBlockCells, stride, cells, cellsY);
        BlockBounds& out = blocks[static_cast<size_t>(x)];
        out.maxSlope = maxWorldSlope(steps, worldFromLattice, mip);
        out.cellRange = steps.cellRange * (1 + 0x1p-20f);
        if (steps.hasHoles) out.flags |= kBlockHasHoles;
        if (steps.hasHoles && mip == 0) out.flags |= kBlockFinestHasHoles;
    }
}

void setHeights(BlockBounds& block, int mip, bool isEmpty, float minZ, float maxZ) {
    block.minZ = isEmpty ? 0 : minZ;
    block.maxZ = isEmpty ? -1 : maxZ;
    if (!isEmpty && mip == 0) block.flags |= kBlockFinestHasCells;
}

float largestError(std::span<const float> worst, int first, int last) {
    const int end = std::min(last, static_cast<int>(worst.size()) - 1);
    float error = 0;
    for (int k = first; k <= end; ++k) error = std::max(error, worst[static_cast<size_t>(k)]);
    return error;
}

float withRounding(float error, const BlockBounds& block, int shift) {
    if (block.minZ > block.maxZ) return error;
    const float magnitude = std::max(std::abs(block.minZ), std::abs(block.maxZ)) + error;
    return error + differenceRounding(magnitude, shift);
}

void inheritFromFiner(BlockBounds& block, const BlockBounds& finer, int mip) {
    block.flags |= finer.flags & (kBlockFinestHasHoles | kBlockFinestHasCells);
    block.cellRange = std::max(block.cellRange, finer.cellRange);
    if (mip == 1) block.errorToFinest = std::max(block.errorToFinest, finer.errorToNext);
}

void setCoverage(BlockBounds& block, const Affine2& worldFromLattice, int mip) {
    const Affine2& map = worldFromLattice;
    const double diagonal =
        std::max(glm::length(map.column + map.row), glm::length(map.column - map.row));
    const bool finestHoles = (block.flags & kBlockFinestHasHoles) != 0;
    const bool finestCells = (block.flags & kBlockFinestHasCells) != 0;
    const bool allHole = !finestCells && block.minZ > block.maxZ;
    block.coverageError =
        finestHoles && !allHole ? static_cast<float>(std::ldexp(diagonal, mip) * (1 + 1e-6)) : 0.0f;
}

}  // namespace terray
