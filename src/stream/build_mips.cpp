// SPDX-License-Identifier: Apache-2.0
// Coarser posts, pyramids and exact errors of a resident terrain, in small windows on all cores.
#include "stream/build_mips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/progress.h"
#include "base/workers.h"
#include "stream/slot.h"
#include "tile/block_bounds.h"

namespace terray {
namespace {

/// A row of blocks of a tile: the unit of work, small enough for a core's cache.
struct Strip {
    uint32_t slot;
    int blockRow;
};

class Builder {
public:
    explicit Builder(ResidentTerrain::Pool& pool) : pool_(pool) {}

    Result<void> run() {
        std::vector<Strip> all;
        for (int mip = 0; mip < pool_.mips; ++mip) {
            const std::vector<Strip> strips = stripsOf(mip);
            all.insert(all.end(), strips.begin(), strips.end());
        }
        Progress progress("Building mips", 2.0 * static_cast<double>(all.size()) +
                                               static_cast<double>(pool_.tiles.size()));
        for (int mip = 1; mip < pool_.mips; ++mip) {
            TERRAY_TRY(eachStrip<CoarseFitter>(
                stripsOf(mip), progress,
                [this](CoarseFitter& fitter, Strip strip) { makePosts(fitter, strip); }));
        }
        TERRAY_TRY(eachSlot(progress));
        TERRAY_TRY(eachStrip<SurfaceComparer>(
            all, progress,
            [this](SurfaceComparer& comparer, Strip strip) { measureStrip(comparer, strip); }));
        for (uint32_t slot = pool_.mips > 1 ? pool_.firstTile[1] : 0; slot < pool_.tiles.size();
             ++slot) {
            inheritBlocks(slot);
        }
        return {};
    }

    /// What is left to do for finished tiles: pyramids; bounds but for heights are the source's.
    Result<void> take(const TileSource& source) {
        Progress progress("Building pyramids", static_cast<double>(pool_.tiles.size()));
        TERRAY_TRY(eachSlot(progress));
        for (uint32_t slot = 0; slot < pool_.tiles.size(); ++slot) {
            const TileId id = pool_.ids[slot];
            for (int k = 0; k < int{kBlocksPerTile}; ++k) {
                const int x = k % kTileBlocks, y = k / kTileBlocks;
                BlockBounds& out = block(slot, x, y);
                const BlockBounds own = std::exchange(out, source.block(id, x, y));
                out.minZ = own.minZ;
                out.maxZ = own.maxZ;
            }
        }
        return {};
    }

private:
    std::vector<Strip> stripsOf(int mip) const {
        std::vector<Strip> strips;
        const uint32_t first = pool_.firstTile[static_cast<size_t>(mip)];
        const uint32_t count = static_cast<uint32_t>(pool_.scheme.tileCount(mip));
        for (uint32_t slot = first; slot < first + count; ++slot) {
            const int blockRows = (pool_.cellsY(pool_.ids[slot]) + kBlockCells - 1) / kBlockCells;
            for (int blockRow = 0; blockRow < blockRows; ++blockRow) {
                strips.push_back({slot, blockRow});
            }
        }
        return strips;
    }

    template <class Worker, class Work>
    Result<void> eachStrip(const std::vector<Strip>& strips, Progress& progress, const Work& work) {
        const auto makeWorker = [] { return Result<Worker>(Worker()); };
        const auto step = [&](Worker& worker, int64_t task) -> Result<void> {
            work(worker, strips[static_cast<size_t>(task)]);
            progress.advance();
            return {};
        };
        return forEachTask(static_cast<int64_t>(strips.size()), makeWorker, step);
    }

    Result<void> eachSlot(Progress& progress) {
        const auto makeWorker = [] { return Result<int>(0); };
        const auto step = [&](int&, int64_t slot) -> Result<void> {
            makePyramid(pool_, static_cast<uint32_t>(slot));
            takeHeights(static_cast<uint32_t>(slot));
            makeSharpness(pool_, static_cast<uint32_t>(slot));
            progress.advance();
            return {};
        };
        return forEachTask(static_cast<int64_t>(pool_.tiles.size()), makeWorker, step);
    }

    void makePosts(CoarseFitter& fitter, Strip strip) const;
    void takeHeights(uint32_t slot);
    void measureStrip(SurfaceComparer& comparer, Strip strip);
    void measureStepsOf(Strip strip);
    void measureErrors(SurfaceComparer& comparer, Strip strip, int coarseMip, int fineMip);
    void inheritBlocks(uint32_t slot);

    BlockBounds& block(uint32_t slot, int x, int y) {
        return pool_.blocks[slot * kBlocksPerTile + static_cast<size_t>(y * kTileBlocks + x)];
    }
    int stripRows(Strip strip) const {
        return std::min(kBlockCells,
                        pool_.cellsY(pool_.ids[strip.slot]) - strip.blockRow * kBlockCells);
    }

    ResidentTerrain::Pool& pool_;
};

/// The tile's last strip makes its last row too. Posts on borders are made again by each tile that
/// holds them, to the same value.
void Builder::makePosts(CoarseFitter& fitter, Strip strip) const {
    const TileId id = pool_.ids[strip.slot];
    const MipRows fine(pool_, id.mip - 1);
    const int first = strip.blockRow * kBlockCells, width = pool_.cellsX(id) + 1;
    const bool last = first + kBlockCells >= pool_.cellsY(id);
    const int height = stripRows(strip) + (last ? 1 : 0);
    std::vector<float> posts(static_cast<size_t>(width) * static_cast<size_t>(height));
    fitter.fit(fine, int64_t{id.x} * kTileCells, int64_t{id.y} * kTileCells + first, width, height,
               posts.data(), width);
    for (int row = 0; row < height; ++row) {
        pool_.encodeRow(strip.slot, first + row, posts.data() + static_cast<ptrdiff_t>(row) * width,
                        width);
    }
}

/// The blocks of 64 x 64 cells are the pyramid's level 6.
void Builder::takeHeights(uint32_t slot) {
    constexpr int kBlockLevel = 6;
    static_assert(kTileCells >> kBlockLevel == kTileBlocks);
    const TileDesc& tile = pool_.tiles[slot];
    const uint32_t* entries = pool_.bounds + tile.bounds + levelOffset(kBlockLevel);
    for (int k = 0; k < int{kBlocksPerTile}; ++k) {
        const uint32_t entry = entries[k];
        const auto height = [&](uint32_t code) {
            return std::fma(tile.boundsStep, static_cast<float>(code), tile.boundsZ0);
        };
        setHeights(block(slot, k % kTileBlocks, k / kTileBlocks), pool_.ids[slot].mip,
                   entry == kEmptyBounds, height(entry & 0xFFFFu), height(entry >> 16));
    }
}

void Builder::measureStrip(SurfaceComparer& comparer, Strip strip) {
    const int mip = pool_.ids[strip.slot].mip;
    measureStepsOf(strip);
    if (mip + 1 < pool_.mips) measureErrors(comparer, strip, mip + 1, mip);
    if (mip >= 2) measureErrors(comparer, strip, mip, 0);
}

void Builder::measureStepsOf(Strip strip) {
    const TileId id = pool_.ids[strip.slot];
    const int width = pool_.cellsX(id) + 1, rows = stripRows(strip);
    std::vector<float> posts(static_cast<size_t>(width) * static_cast<size_t>(rows + 1));
    for (int row = 0; row <= rows; ++row) {
        pool_.decodeRow(strip.slot, strip.blockRow * kBlockCells + row, 0, width,
                        posts.data() + static_cast<ptrdiff_t>(row) * width);
    }
    measureSteps(posts.data(), width, width - 1, rows, pool_.worldFromLattice, id.mip,
                 {&block(strip.slot, 0, strip.blockRow), kTileBlocks});
}

/// Either fineMip == 0: errors of the strip's own mip to mip 0; or coarseMip is the next mip:
/// errors of that one, over the strip's blocks.
void Builder::measureErrors(SurfaceComparer& comparer, Strip strip, int coarseMip, int fineMip) {
    const TileId id = pool_.ids[strip.slot];
    const MipRows coarse(pool_, coarseMip), fine(pool_, fineMip);
    const bool toNext = coarseMip > id.mip;
    const int shift = coarseMip - fineMip, up = coarseMip - id.mip;
    const int blockPosts = kBlockCells << (id.mip - fineMip);   // fine posts across a block
    const int together = std::max(1, 8 >> (id.mip - fineMip));  // blocks compared at once
    const int rows = (stripRows(strip) + up) >> up;
    const int cellsX = pool_.cellsX(id);
    const int64_t row = (int64_t{id.y} * kTileCells + strip.blockRow * kBlockCells) >> up;
    for (int x = 0; x * kBlockCells < cellsX; x += together) {
        const int first = x * kBlockCells;
        const int cells = (std::min(together * kBlockCells, cellsX - first) + up) >> up;
        const int64_t column = (int64_t{id.x} * kTileCells + first) >> up;
        const std::span<const float> worst =
            comparer.compare(coarse, fine, shift, column, row, cells, rows);
        const auto posts = static_cast<int>(worst.size());
        for (int b = 0; b < together && b * blockPosts < posts - 1; ++b) {
            BlockBounds& out = block(strip.slot, x + b, strip.blockRow);
            const float error = largestError(worst, b * blockPosts, (b + 1) * blockPosts);
            (toNext ? out.errorToNext : out.errorToFinest) = withRounding(error, out, shift);
        }
    }
}

void Builder::inheritBlocks(uint32_t slot) {
    const TileId id = pool_.ids[slot];
    if (id.mip == 0) return;
    for (int k = 0; k < int{kBlocksPerTile}; ++k) {
        const int x = k % kTileBlocks, y = k / kTileBlocks;
        BlockBounds& out = block(slot, x, y);
        for (int child = 0; child < 4; ++child) {
            const int childX = 2 * x + child % 2, childY = 2 * y + child / 2;
            const TileId finer{id.mip - 1, 2 * id.x + childX / kTileBlocks,
                               2 * id.y + childY / kTileBlocks};
            const uint32_t finerSlot = pool_.slotOf(finer);
            if (finerSlot == kNoSlot) continue;
            inheritFromFiner(out, block(finerSlot, childX % kTileBlocks, childY % kTileBlocks),
                             id.mip);
        }
        setCoverage(out, pool_.worldFromLattice, id.mip);
    }
}

}  // namespace

Result<void> buildMips(ResidentTerrain::Pool& pool) { return Builder(pool).run(); }

Result<void> takeMips(const TileSource& source, ResidentTerrain::Pool& pool) {
    return Builder(pool).take(source);
}

}  // namespace terray
