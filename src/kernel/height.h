// SPDX-License-Identifier: Apache-2.0
// Reading the surface of a cut at places: heights of posts and cells, for shading, query and
// cameras.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "kernel/layout/layout.h"

namespace terray {

/// Decoded post (i, j), 0..512, of the tile in a slot; NaN for a hole.
inline float postHeight(const TerrainCut& cut, const TileDesc& tile, int i, int j) {
    const uint64_t index =
        tile.posts + static_cast<uint64_t>(j) * kPostStride + static_cast<uint64_t>(i);
    if (cut.format == 1) return static_cast<const float*>(cut.posts)[index];
    const uint16_t code = static_cast<const uint16_t*>(cut.posts)[index];
    if (code == 0xFFFF) return std::numeric_limits<float>::quiet_NaN();
    // The product is exact in double, so that this rounds once, as a float fma does, but on any
    // machine.
    return static_cast<float>(static_cast<double>(tile.zStep) * code +
                              static_cast<double>(tile.z0));
}

/// Slot of the resident tile of a mip that holds the lattice cell (column, row of mip 0); kNoSlot
/// if none.
inline uint32_t slotAt(const TerrainCut& cut, int mip, int64_t column, int64_t row) {
    if (mip > cut.rootLevel || column < 0 || row < 0) return kNoSlot;
    const DirectoryLevel& level = cut.levels[mip];
    const int64_t x = column >> (9 + mip), y = row >> (9 + mip);
    if (x >= level.columns || y >= level.rows) return kNoSlot;
    return cut
        .squares[level.offset + static_cast<uint64_t>(y) * level.columns + static_cast<uint64_t>(x)]
        .slot;
}

/// The drawn tile over the mip-0 cell (column, row) of the lattice, kNoSlot where nothing is drawn.
uint32_t drawnSlotAt(const TerrainCut& cut, int64_t column, int64_t row);

/// A cell of the drawn surface under a lattice place.
struct SurfaceCell {
    uint32_t slot = kNoSlot;  ///< kNoSlot: outside, or a hole
    int mip = 0;
    int x = 0, y = 0;                          ///< cell in the tile, 0..511
    double u = 0, v = 0;                       ///< place in the cell, 0..1
    float h00 = 0, h10 = 0, h01 = 0, h11 = 0;  ///< posts: (x, y), (x+1, y), (x, y+1), (x+1, y+1)
    double height(SurfaceKind surface) const;
};
/// The drawn cell at a lattice place (i, j in mip-0 posts).
SurfaceCell surfaceCellAt(const TerrainCut& cut, double i, double j);

/// Height of a drawn cell of a hit (its own tile and cell), metres; `hit` must be valid.
double hitHeight(const TerrainCut& cut, const Hit& hit);

/// Lattice place of a hit.
struct LatticePlace {
    double i = 0, j = 0;
};
inline LatticePlace hitPlace(const TerrainCut& cut, const Hit& hit) {
    const TileDesc& tile = cut.tiles[hit.tile];
    const double size = static_cast<double>(1u << hit.mip);
    return {tile.x + (static_cast<double>(cellX(hit)) + static_cast<double>(hit.u)) * size,
            tile.y + (static_cast<double>(cellY(hit)) + static_cast<double>(hit.v)) * size};
}

}  // namespace terray
