// SPDX-License-Identifier: Apache-2.0
// Cuts: the directory of a frame, filled from its root down by what the selector allows.
#include "stream/cut.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/assert.h"
#include "kernel/pyramid.h"
#include "stream/pool.h"
#include "stream/tile_rule.h"

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
        squares.resize(pool.slots.size());
        for (size_t number = 0; number < squares.size(); ++number) {
            squares[number] = Square{0, 0, pool.slots[number], kSquareCovered};
        }
        for (int mip = 0; mip < pool.mips; ++mip) {
            // Squares stand in the order of the tiles' numbers.
            cut.levels[mip] = DirectoryLevel{pool.firstTile[static_cast<size_t>(mip)],
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

    Square& draw(uint32_t number) {
        Square& square = squares[number];
        const uint32_t slot = square.slot;
        if (slot == kNoSlot) {
            TERRAY_ASSERT(pool.isHollow(number));
            square.state = kSquareEmpty;
            return square;
        }
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
        for (const BlockBounds& block : pool.blocksOf(number)) {
            const float error = block.errorToFinest +
                                (cut.surface != kSurfaceBilinear ? 2 * block.cellRange : 0.0f);
            if ((tile.mipFlags & kTileMipMask) != 0) cut.maxError = std::max(cut.maxError, error);
        }
        return square;
    }

    /// Draws the tile where `serves` says so or finer ones are not there, else its children.
    template <class Serves>
    const Square& fill(TileId id, const Serves& serves) {
        const uint32_t number = pool.numberOf(id);
        if (id.mip == 0 || serves(number)) return draw(number);
        uint32_t finer[4];
        const int count = childrenOf(pool, id, finer);
        if (!std::all_of(finer, finer + count, [&](uint32_t n) { return pool.isHere(n); })) {
            standIns.push_back(number);
            return draw(number);
        }
        Square& square = squares[number];
        square.minZ = kInfinity;
        square.maxZ = -kInfinity;
        square.state = kSquareEmpty;
        for (int child = 0; child < count; ++child) {
            const Square& inside = fill(pool.tileOf(finer[child]), serves);
            if (inside.state == kSquareEmpty) continue;
            square.state = kSquareDescend;
            square.minZ = std::min(square.minZ, inside.minZ);
            square.maxZ = std::max(square.maxZ, inside.maxZ);
        }
        return square;
    }

    /// Takes all other tiles but the pool's coarse ones, which stay, out of the page table.
    void hideAllBut(std::span<const TileId> shown) {
        std::vector<uint8_t> isShown(squares.size(), 0);
        for (const TileId id : shown) isShown[pool.numberOf(id)] = 1;
        const uint32_t kept = pool.firstTile[static_cast<size_t>(pool.firstKept)];
        for (uint32_t number = 0; number < kept; ++number) {
            if (!isShown[number]) squares[number].slot = kNoSlot;
        }
    }

    float lowestCode = kInfinity, highestCode = -kInfinity;  ///< of drawn tiles' z0
    std::vector<uint32_t> standIns = {};  ///< tiles drawn because finer ones are absent
};

}  // namespace

FrameCut selectCut(const ResidentTerrain& terrain, const Camera& camera, const CutOptions& options,
                   std::span<const TileId> wanted) {
    const ResidentTerrain::Pool& pool = terrain.pool();
    if (options.tolerancePx <= 0 && pool.isWhole()) return finestCut(terrain, options.surface);
    FrameCut frame;
    Directory directory{pool, frame.cut_, frame.squares_, frame.tilesPerMip_};
    directory.start(options.surface);
    const TileRule rule(terrain, camera, options);
    directory.finish(directory.fill(TileId{pool.mips - 1, 0, 0},
                                    [&](uint32_t number) { return rule.serves(number); }));
    frame.standIns_ = directory.standIns.size();
    for (const uint32_t number : directory.standIns) {
        if (pool.isHollow(number)) continue;
        frame.lateBlocks_.resize(pool.tiles.size(), 0);
        frame.lateBlocks_[pool.slots[number]] = rule.lateBlocks(number);
    }
    if (!pool.isWhole() && wanted.empty()) directory.hideAllBut(rule.wanted());
    if (!wanted.empty()) directory.hideAllBut(wanted);
    return frame;
}

std::vector<TileId> wantedTiles(const ResidentTerrain& terrain, const Camera& camera,
                                const CutOptions& options) {
    return TileRule(terrain, camera, options).wanted();
}

FrameCut finestCut(const ResidentTerrain& terrain, SurfaceKind surface) {
    FrameCut frame;
    Directory directory{terrain.pool(), frame.cut_, frame.squares_, frame.tilesPerMip_};
    directory.start(surface);
    directory.finish(
        directory.fill(TileId{terrain.pool().mips - 1, 0, 0}, [](uint32_t) { return false; }));
    frame.standIns_ = directory.standIns.size();
    return frame;
}

FrameCut cutOf(const ResidentTerrain& terrain, SurfaceKind surface, std::span<const TileId> tiles) {
    const ResidentTerrain::Pool& pool = terrain.pool();
    FrameCut frame;
    Directory directory{pool, frame.cut_, frame.squares_, frame.tilesPerMip_};
    directory.start(surface);
    for (Square& square : frame.squares_) square.state = kSquareEmpty;
    for (TileId id : tiles) {
        const Square drawn = directory.draw(pool.numberOf(id));
        if (drawn.state == kSquareEmpty) continue;
        while (++id.mip < pool.mips) {
            id = {id.mip, id.x / 2, id.y / 2};
            Square& above = frame.squares_[pool.numberOf(id)];
            const bool isFirst = above.state == kSquareEmpty;
            above.state = kSquareDescend;
            above.minZ = isFirst ? drawn.minZ : std::min(above.minZ, drawn.minZ);
            above.maxZ = isFirst ? drawn.maxZ : std::max(above.maxZ, drawn.maxZ);
        }
    }
    directory.finish(frame.squares_.back());
    return frame;
}

}  // namespace terray
