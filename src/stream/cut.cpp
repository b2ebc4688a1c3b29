// SPDX-License-Identifier: Apache-2.0
// Cuts: the directory of a frame, filled from its root down by what the selector allows.
#include "stream/cut.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/pyramid.h"
#include "stream/pool.h"
#include "stream/selector.h"

namespace terray {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// A directory under construction: all squares known by slot, covered until something else is said.
struct Directory {
    const ResidentTerrain::Pool& pool;
    TerrainCut& cut;
    std::vector<Square>& squares;
    std::vector<uint64_t>& tilesPerMip;

    void start(SurfaceKind surface) {
        cut.tiles = pool.tiles.data();
        cut.posts = pool.posts;
        cut.bounds = pool.bounds;
        cut.sharpness = pool.sharpness.data();
        cut.maxSharpness = 0;
        cut.hasHoles = 0;
        cut.rootLevel = pool.mips - 1;
        cut.format = static_cast<uint32_t>(pool.format);
        cut.surface = surface;
        cut.tileCount = static_cast<uint32_t>(pool.tiles.size());
        cut.cellsX = static_cast<int32_t>(pool.scheme.columns - 1);
        cut.cellsY = static_cast<int32_t>(pool.scheme.rows - 1);
        squares.resize(pool.tiles.size());
        for (uint32_t slot = 0; slot < pool.tiles.size(); ++slot) {
            squares[slot] = Square{0, 0, slot, kSquareCovered};
        }
        for (int mip = 0; mip < pool.mips; ++mip) {
            // Squares stand in the order of the slots.
            cut.levels[mip] = DirectoryLevel{pool.firstSlot[static_cast<size_t>(mip)],
                                             static_cast<uint32_t>(pool.scheme.tilesX(mip)),
                                             static_cast<uint32_t>(pool.scheme.tilesY(mip))};
        }
        tilesPerMip.assign(static_cast<size_t>(pool.mips), 0);
    }

    /// Ends the directory: figures of the whole.
    void finish(const Square& root) {
        cut.squares = squares.data();
        const bool any = root.state != kSquareEmpty;
        cut.minZ = any ? root.minZ : 0;
        cut.maxZ = any ? root.maxZ : 0;
        const float middle = 0.5f * (cut.minZ + cut.maxZ);
        if (any) cut.codeReach = std::max(middle - lowestCode, highestCode - middle);
        const auto drawn = [](uint64_t tiles) { return tiles != 0; };
        cut.unlikeMips = std::count_if(tilesPerMip.begin(), tilesPerMip.end(), drawn) > 1 ? 1 : 0;
    }

    Square& draw(uint32_t slot) {
        Square& square = squares[slot];
        const SlotBounds& bounds = pool.slotBounds[slot];
        const TileDesc& tile = pool.tiles[slot];
        square.minZ = bounds.minZ;
        square.maxZ = bounds.maxZ;
        square.state = bounds.minZ <= bounds.maxZ ? kSquareDrawn : kSquareEmpty;
        if (bounds.hasHoles) cut.hasHoles = 1;
        if (square.state == kSquareEmpty) return square;
        ++tilesPerMip[tile.mipFlags & kTileMipMask];
        cut.maxDelta = std::max(cut.maxDelta, tile.maxDelta);
        const int mip = static_cast<int>(tile.mipFlags & kTileMipMask);
        cut.maxSharpness = std::max(cut.maxSharpness, std::ldexp(bounds.sharpest, -mip));
        lowestCode = std::min({lowestCode, tile.boundsZ0, cut.format == 0 ? tile.z0 : lowestCode});
        highestCode =
            std::max({highestCode, tile.boundsZ0, cut.format == 0 ? tile.z0 : highestCode});
        for (const BlockBounds& block : blocksOf(slot)) {
            const float error = block.errorToFinest +
                                (cut.surface != kSurfaceBilinear ? 2 * block.cellRange : 0.0f);
            if ((tile.mipFlags & kTileMipMask) != 0) cut.maxError = std::max(cut.maxError, error);
        }
        return square;
    }

    /// Draws the tile where `serves` says so, else its children.
    template <class Serves>
    const Square& fill(TileId id, const Serves& serves) {
        const uint32_t slot = pool.slotOf(id);
        if (id.mip == 0 || serves(slot)) return draw(slot);
        Square& square = squares[slot];
        square.minZ = kInfinity;
        square.maxZ = -kInfinity;
        square.state = kSquareEmpty;
        for (int child = 0; child < 4; ++child) {
            const TileId finer{id.mip - 1, 2 * id.x + child % 2, 2 * id.y + child / 2};
            if (pool.slotOf(finer) == kNoSlot) continue;
            const Square& inside = fill(finer, serves);
            if (inside.state == kSquareEmpty) continue;
            square.state = kSquareDescend;
            square.minZ = std::min(square.minZ, inside.minZ);
            square.maxZ = std::max(square.maxZ, inside.maxZ);
        }
        return square;
    }

    float lowestCode = kInfinity, highestCode = -kInfinity;  ///< of drawn tiles' z0

    std::span<const BlockBounds> blocksOf(uint32_t slot) const {
        constexpr size_t count = kTileBlocks * kTileBlocks;
        return {pool.blocks.data() + slot * count, count};
    }
};

/// True if every block of a tile may be drawn.
bool tileServes(const Directory& directory, const Selector& selector, uint32_t slot) {
    const ResidentTerrain::Pool& pool = directory.pool;
    const TileDesc& tile = pool.tiles[slot];
    const double blockSize = std::ldexp(kBlockCells, pool.ids[slot].mip);
    const std::span<const BlockBounds> blocks = directory.blocksOf(slot);
    for (int y = 0; y < kTileBlocks; ++y) {
        for (int x = 0; x < kTileBlocks; ++x) {
            const double i0 = tile.x + x * blockSize, j0 = tile.y + y * blockSize;
            if (i0 >= directory.cut.cellsX || j0 >= directory.cut.cellsY) continue;
            const LatticeBox box{i0, j0, std::min<double>(i0 + blockSize, directory.cut.cellsX),
                                 std::min<double>(j0 + blockSize, directory.cut.cellsY)};
            if (!selector.serves(blocks[static_cast<size_t>(y * kTileBlocks + x)], box)) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace

FrameCut selectCut(const ResidentTerrain& terrain, const Camera& camera,
                   const CutOptions& options) {
    if (options.tolerancePx <= 0) return finestCut(terrain, options.surface);
    const ResidentTerrain::Pool& pool = terrain.pool();
    FrameCut frame;
    Directory directory{pool, frame.cut_, frame.squares_, frame.tilesPerMip_};
    directory.start(options.surface);
    const Selector selector(pool.worldFromLattice, static_cast<double>(terrain.info().minZ), camera,
                            options);
    directory.finish(directory.fill(TileId{pool.mips - 1, 0, 0}, [&](uint32_t slot) {
        return tileServes(directory, selector, slot);
    }));
    return frame;
}

FrameCut finestCut(const ResidentTerrain& terrain, SurfaceKind surface) {
    FrameCut frame;
    Directory directory{terrain.pool(), frame.cut_, frame.squares_, frame.tilesPerMip_};
    directory.start(surface);
    directory.finish(
        directory.fill(TileId{terrain.pool().mips - 1, 0, 0}, [](uint32_t) { return false; }));
    return frame;
}

}  // namespace terray
