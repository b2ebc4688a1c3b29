// SPDX-License-Identifier: Apache-2.0
// Measuring blocks, post by post.
#include "kernel/scalar/block_ranges.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/scalar/oracle.h"

namespace terray::oracle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void add(BlockRanges::Range& range, const BlockRanges::Range& other) {
    range.low = std::min(range.low, other.low);
    range.high = std::max(range.high, other.high);
}

}  // namespace

BlockRanges::BlockRanges(const TerrainCut& cut) : firsts_(cut.tileCount, 0) {
    std::vector<uint32_t> drawn;
    for (int d = 0; d <= cut.rootLevel; ++d) {
        const DirectoryLevel& level = cut.levels[d];
        for (uint32_t k = 0; k < level.columns * level.rows; ++k) {
            const Square& square = cut.squares[level.offset + k];
            if (square.state == kSquareDrawn) drawn.push_back(square.slot);
        }
    }
    for (size_t k = 0; k < drawn.size(); ++k) firsts_[drawn[k]] = k * (kLarge + kSmall);
    ranges_.assign(drawn.size() * (kLarge + kSmall), {kInfinity, -kInfinity});
    tbb::parallel_for(size_t{0}, drawn.size(), [&](size_t k) { measureTile(cut, drawn[k]); });
}

/// A post counts for every block that touches it. Posts beyond the terrain's rim are no holes: no
/// ray gets there.
void BlockRanges::measureTile(const TerrainCut& cut, uint32_t slot) {
    constexpr int kSide = kSlotCells >> kShift[1], kBlock = 1 << kShift[1];
    const TileDesc& tile = cut.tiles[slot];
    const int mip = static_cast<int>(tile.mipFlags & kTileMipMask);
    const auto cells = [mip](int size, int first) {
        return std::clamp((size - first + (1 << mip) - 1) >> mip, 0, kSlotCells);
    };
    const int cellsX = cells(cut.cellsX, tile.x), cellsY = cells(cut.cellsY, tile.y);
    Range* large = ranges_.data() + firsts_[slot];
    Range* small = large + kLarge;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            Range& range = small[y * kSide + x];
            for (int j = y * kBlock; j <= std::min((y + 1) * kBlock, cellsY); ++j) {
                for (int i = x * kBlock; i <= std::min((x + 1) * kBlock, cellsX); ++i) {
                    const double z = post(cut, slot, i, j);
                    add(range, std::isfinite(z) ? Range{z, z} : Range{-kInfinity, kInfinity});
                }
            }
            add(large[(y >> 3) * 8 + (x >> 3)], range);
        }
    }
}

int sideOf(const BlockRanges::Range& range, const Ray& ray, double from, double to) {
    const auto height = [&ray](double t) { return ray.z + (ray.dz + ray.bend * t) * t; };
    const double a = height(from), b = height(to), turn = -ray.dz / (2 * ray.bend);
    double low = std::min(a, b);
    const double high = std::max(a, b);
    if (ray.bend > 0 && turn > from && turn < to) low = height(turn);
    const double room = 1e-6 + 1e-9 * (std::abs(a) + std::abs(b) + std::abs(ray.z));
    if (low > range.high + room) return 1;
    return high < range.low - room ? -1 : 0;
}

}  // namespace terray::oracle
