// SPDX-License-Identifier: Apache-2.0
// From blocks to tiles, and from tiles to the list of those that a frame wants.
#include "stream/tile_rule.h"

#include <algorithm>
#include <cmath>

namespace terray {

TileRule::TileRule(const ResidentTerrain& terrain, const Camera& camera, const CutOptions& options)
    : pool_(terrain.pool()),
      selector_(pool_.worldFromLattice, static_cast<double>(terrain.info().minZ), camera, options),
      range_{static_cast<double>(terrain.info().minZ), static_cast<double>(terrain.info().maxZ)},
      volume_(selector_, pool_.worldFromLattice, camera, options),
      options_(options) {}

LatticeBox TileRule::boxOf(uint32_t number, int firstBlockX, int firstBlockY, int blocks) const {
    const TileId id = pool_.tileOf(number);
    const double cells = std::ldexp(kBlockCells, id.mip);
    const double i0 = (static_cast<double>(id.x) * kTileBlocks + firstBlockX) * cells;
    const double j0 = (static_cast<double>(id.y) * kTileBlocks + firstBlockY) * cells;
    return {i0, j0, std::min(i0 + blocks * cells, static_cast<double>(pool_.scheme.columns - 1)),
            std::min(j0 + blocks * cells, static_cast<double>(pool_.scheme.rows - 1))};
}

bool TileRule::blockServes(const BlockBounds& block, const LatticeBox& box) const {
    // Where coverage differs mip 0 may stand, at any height, where this mip has nothing.
    const bool isSeen =
        volume_.mayShow(box, block.coverageError > 0 ? range_ : selector_.trueHeights(block));
    if (isSeen && !selector_.servesInView(block, box)) return false;
    if (selector_.servesInShadows(block, box)) return true;
    LatticeBox shadow = box;
    const Selector::Heights heights = selector_.shadowed(block, shadow);
    return !volume_.mayShow(shadow, heights);
}

bool TileRule::serves(uint32_t number) const {
    const std::span<const BlockBounds> blocks = pool_.blocksOf(number);
    for (int y = 0; y < kTileBlocks; ++y) {
        for (int x = 0; x < kTileBlocks; ++x) {
            const LatticeBox box = boxOf(number, x, y, 1);
            if (box.i0 >= box.i1 || box.j0 >= box.j1) continue;
            if (!blockServes(blocks[static_cast<size_t>(y * kTileBlocks + x)], box)) return false;
        }
    }
    return true;
}

uint64_t TileRule::lateBlocks(uint32_t number) const {
    const std::span<const BlockBounds> blocks = pool_.blocksOf(number);
    uint64_t late = 0;
    for (int k = 0; k < static_cast<int>(kBlocksPerTile); ++k) {
        const LatticeBox box = boxOf(number, k % kTileBlocks, k / kTileBlocks, 1);
        if (box.i0 >= box.i1 || box.j0 >= box.j1) continue;
        if (selector_.missesTolerance(blocks[static_cast<size_t>(k)], box))
            late |= uint64_t{1} << k;
    }
    return late;
}

bool TileRule::isShadedFiner(uint32_t number) const {
    const TileId id = pool_.tileOf(number);
    if (id.mip == 0) return false;
    const std::span<const BlockBounds> blocks = pool_.blocksOf(number);
    for (int y = 0; y < kTileBlocks; ++y) {
        for (int x = 0; x < kTileBlocks; ++x) {
            const BlockBounds& block = blocks[static_cast<size_t>(y * kTileBlocks + x)];
            LatticeBox box = boxOf(number, x, y, 1);
            if (box.i0 >= box.i1 || box.j0 >= box.j1 || block.minZ > block.maxZ) continue;
            // A place just beside the block reads its posts too.
            const double cell = std::ldexp(1.0, id.mip);
            box = {box.i0 - cell, box.j0 - cell, box.i1 + cell, box.j1 + cell};
            if (volume_.finestMip(box, block) < id.mip) return true;
        }
    }
    return false;
}

std::vector<TileId> TileRule::wanted() const {
    std::vector<TileId> all, level;
    level.push_back({pool_.mips - 1, 0, 0});
    while (!level.empty()) {
        std::stable_sort(level.begin(), level.end(), [&](TileId a, TileId b) {
            const auto away = [&](TileId id) {
                return selector_.groundDistance2(boxOf(pool_.numberOf(id), 0, 0, kTileBlocks));
            };
            return away(a) < away(b);
        });
        for (const TileId id : level) {
            if (!pool_.isHollow(pool_.numberOf(id))) all.push_back(id);
        }
        std::vector<TileId> finer;
        for (const TileId id : level) {
            const uint32_t number = pool_.numberOf(id);
            if (id.mip == 0 || (serves(number) && !isShadedFiner(number))) continue;
            uint32_t children[4];
            const int count = childrenOf(pool_, id, children);
            for (int k = 0; k < count; ++k) finer.push_back(pool_.tileOf(children[k]));
        }
        level = std::move(finer);
    }
    return all;
}

int childrenOf(const ResidentTerrain::Pool& pool, TileId id, uint32_t (&finer)[4]) {
    int count = 0;
    for (int child = 0; child < 4; ++child) {
        const uint32_t number =
            pool.numberOf({id.mip - 1, 2 * id.x + child % 2, 2 * id.y + child / 2});
        if (number != kNoSlot) finer[count++] = number;
    }
    return count;
}

}  // namespace terray
