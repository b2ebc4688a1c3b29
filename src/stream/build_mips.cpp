// SPDX-License-Identifier: Apache-2.0
// Coarser posts, pyramids and exact errors of a resident terrain, in small windows on all cores.
#include "stream/build_mips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/progress.h"
#include "base/workers.h"
#include "tile/block_bounds.h"

namespace terray {
namespace {

constexpr int kBlocksPerTile = kTileBlocks * kTileBlocks;

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
        for (uint32_t slot = pool_.mips > 1 ? pool_.firstSlot[1] : 0; slot < pool_.tiles.size();
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
            const auto width = static_cast<size_t>(pool_.scheme.tilesX(id.mip)) * kTileBlocks;
            for (int k = 0; k < kBlocksPerTile; ++k) {
                const int x = k % kTileBlocks, y = k / kTileBlocks;
                const size_t row = static_cast<size_t>(id.y) * kTileBlocks + static_cast<size_t>(y);
                const size_t column =
                    static_cast<size_t>(id.x) * kTileBlocks + static_cast<size_t>(x);
                BlockBounds& out = block(slot, x, y);
                const BlockBounds own =
                    std::exchange(out, source.bounds(id.mip)[row * width + column]);
                out.minZ = own.minZ;
                out.maxZ = own.maxZ;
            }
        }
        return {};
    }

private:
    std::vector<Strip> stripsOf(int mip) const {
        std::vector<Strip> strips;
        const uint32_t first = pool_.firstSlot[static_cast<size_t>(mip)];
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
            makePyramid(static_cast<uint32_t>(slot));
            makeSharpness(static_cast<uint32_t>(slot));
            progress.advance();
            return {};
        };
        return forEachTask(static_cast<int64_t>(pool_.tiles.size()), makeWorker, step);
    }

    void makePosts(CoarseFitter& fitter, Strip strip) const;
    void makePyramid(uint32_t slot);
    void makeSharpness(uint32_t slot);
    void measureStrip(SurfaceComparer& comparer, Strip strip);
    void measureStepsOf(Strip strip);
    void measureErrors(SurfaceComparer& comparer, Strip strip, int coarseMip, int fineMip);
    void inheritBlocks(uint32_t slot);

    BlockBounds& block(uint32_t slot, int x, int y) {
        return pool_
            .blocks[size_t{slot} * kBlocksPerTile + static_cast<size_t>(y * kTileBlocks + x)];
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
void Builder::makePyramid(uint32_t slot) {
    constexpr int kBlockLevel = 6;
    static_assert(kTileCells >> kBlockLevel == kTileBlocks);
    const TileId id = pool_.ids[slot];
    TileDesc& tile = pool_.tiles[slot];
    uint32_t* bounds = pool_.bounds + tile.bounds;
    const int cellsX = pool_.cellsX(id), cellsY = pool_.cellsY(id);
    pool_.slotBounds[slot] =
        pool_.format == PostFormat::Int16
            ? buildPyramid(pool_.postsOf<const uint16_t>(slot), cellsX, cellsY, tile, bounds)
            : buildPyramid(pool_.postsOf<const float>(slot), cellsX, cellsY, tile, bounds);
    for (int k = 0; k < kBlocksPerTile; ++k) {
        const uint32_t entry = bounds[levelOffset(kBlockLevel) + static_cast<uint32_t>(k)];
        const auto height = [&](uint32_t code) {
            return std::fma(tile.boundsStep, static_cast<float>(code), tile.boundsZ0);
        };
        setHeights(block(slot, k % kTileBlocks, k / kTileBlocks), id.mip, entry == kEmptyBounds,
                   height(entry & 0xFFFFu), height(entry >> 16));
    }
}

/// Borders are shared: the posts beyond a tile's rim are the second ones of its neighbours.
template <class Post>
struct HaloPosts {
    std::vector<Post> left, right, top, bottom;
    TileHalo<Post> halo() const {
        const auto at = [](const std::vector<Post>& posts) {
            return posts.empty() ? nullptr : posts.data();
        };
        return {at(left), at(right), at(top), at(bottom)};
    }
};
template <class Post>
HaloPosts<Post> haloOf(const ResidentTerrain::Pool& pool, TileId id) {
    HaloPosts<Post> halo;
    const auto take = [&](int dx, int dy, int column, int row, ptrdiff_t step, int count,
                          std::vector<Post>& out) {
        const uint32_t slot = pool.slotOf({id.mip, id.x + dx, id.y + dy});
        if (slot == kNoSlot) return;
        const Post* from = pool.postsOf<Post>(slot) + ptrdiff_t{row} * kPostStride + column;
        for (int k = 0; k < count; ++k) out.push_back(from[k * step]);
    };
    const int width = pool.cellsX(id) + 1, height = pool.cellsY(id) + 1;
    take(-1, 0, kTileCells - 1, 0, kPostStride, height, halo.left);
    take(1, 0, 1, 0, kPostStride, height, halo.right);
    take(0, -1, 0, kTileCells - 1, 1, width, halo.top);
    take(0, 1, 0, 1, 1, width, halo.bottom);
    return halo;
}

void Builder::makeSharpness(uint32_t slot) {
    const TileId id = pool_.ids[slot];
    const int cellsX = pool_.cellsX(id), cellsY = pool_.cellsY(id);
    uint8_t* out = pool_.sharpness.data() + size_t{slot} * kSlotSharpness;
    float& sharpest = pool_.slotBounds[slot].sharpest;
    if (pool_.format == PostFormat::Int16) {
        const auto halo = haloOf<uint16_t>(pool_, id);
        sharpest = buildSharpness(pool_.postsOf<const uint16_t>(slot), cellsX, cellsY, halo.halo(),
                                  pool_.tiles[slot], out);
    } else {
        const auto halo = haloOf<float>(pool_, id);
        sharpest =
            buildSharpness(pool_.postsOf<const float>(slot), cellsX, cellsY, halo.halo(), out);
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
    for (int k = 0; k < kBlocksPerTile; ++k) {
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
