// SPDX-License-Identifier: Apache-2.0
// The rule of a frame for whole tiles: which may be drawn, and which the shading of what is seen
// reads posts of.
#pragma once

#include <vector>

#include "stream/pool.h"
#include "stream/selector.h"
#include "stream/view_volume.h"

namespace terray {

/// const-shared; borrows the terrain.
class TileRule {
public:
    TileRule(const ResidentTerrain& terrain, const Camera& camera, const CutOptions& options);
    TileRule(const TileRule&) = delete;
    TileRule& operator=(const TileRule&) = delete;

    /// Every block of the tile may stand in for mip 0, where it or an edge of its shadow is seen.
    bool serves(uint32_t number) const;
    /// Blocks of the tile (bit 8 y + x) that are seen and miss the tolerance.
    uint64_t lateBlocks(uint32_t number) const;
    /// Something of the tile may be seen so near that shading reads finer posts than its own
    /// (shade/normals.h).
    bool isShadedFiner(uint32_t number) const;

    /// What the frame wants resident: the drawn tiles, those that shading reads, and all coarser
    /// ones over them; coarse ones first, near ones first within a mip.
    std::vector<TileId> wanted() const;

private:
    bool blockServes(const BlockBounds& block, const LatticeBox& box) const;
    LatticeBox boxOf(uint32_t number, int firstBlockX, int firstBlockY, int blocks) const;

    const ResidentTerrain::Pool& pool_;
    Selector selector_;
    Selector::Heights range_;  ///< of the whole terrain
    ViewVolume volume_;
    CutOptions options_;
};

/// Numbers of the tiles of the next finer mip in a tile: 1 to 4 of them.
int childrenOf(const ResidentTerrain::Pool& pool, TileId id, uint32_t (&finer)[4]);

}  // namespace terray
