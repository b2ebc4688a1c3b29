// SPDX-License-Identifier: Apache-2.0
// Ranges of heights of blocks of cells, from the oracle's own posts: the oracle may pass a block
// that a ray clears in one step. For judging rays by the million; kernels and their pyramids have
// no part in it.
#pragma once

#include <vector>

#include "kernel/layout/layout.h"

namespace terray::oracle {

/// Of the drawn tiles of a cut, for any surface: blocks of 8 x 8 and of 64 x 64 cells of the tile.
class BlockRanges {
public:
    struct Range {
        double low, high;  ///< infinite both ways if a cell of the block is a hole
    };
    static constexpr int kLevels = 2;
    static constexpr int kShift[kLevels] = {6, 3};  ///< the larger first

    explicit BlockRanges(const TerrainCut& cut);

    /// Of the block that holds cell (i, j) of a drawn tile.
    const Range& at(uint32_t slot, int level, int i, int j) const {
        const int shift = kShift[level], side = kSlotCells >> shift;
        return ranges_[firsts_[slot] + (level == 0 ? 0 : kLarge) +
                       static_cast<size_t>((j >> shift) * side + (i >> shift))];
    }

private:
    static constexpr size_t kLarge = 8 * 8, kSmall = 64 * 64;
    void measureTile(const TerrainCut& cut, uint32_t slot);

    std::vector<size_t> firsts_;  ///< per slot, in ranges_
    std::vector<Range> ranges_;
};

/// 1 (-1): a ray is above (below) a range of heights between two distances, with room to spare;
/// else 0.
int sideOf(const BlockRanges::Range& range, const Ray& ray, double from, double to);

}  // namespace terray::oracle
