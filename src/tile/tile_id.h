// SPDX-License-Identifier: Apache-2.0
// Names and extents of tiles on the nested, vertex-centred lattice (docs/surface.md).
#pragma once

#include <cstdint>

namespace terray {

constexpr int kTileCells = 512;  ///< cells a side of every tile
constexpr int kTileCellsLog2 = 9;
constexpr int kTilePosts =
    kTileCells + 1;  ///< posts a side: the last row and column are the neighbours' first
constexpr int kBlockCells = 64;                        ///< BlockBounds are kept per 64 x 64 cells
constexpr int kTileBlocks = kTileCells / kBlockCells;  ///< 8 blocks a side
constexpr int kMaxMips = 24;

/// Tile (x, y) of mip m covers the posts x * 512 ... x * 512 + 512 of that mip.
struct TileId {
    int mip = 0, x = 0, y = 0;
    friend bool operator==(const TileId&, const TileId&) = default;
};

/// Sizes of the lattice and of its coarser mips. Post (i, j) of mip m+1 stands on post (2i, 2j) of
/// mip m.
struct TilingScheme {
    int64_t columns = 0, rows = 0;  ///< posts of mip 0, each >= 2

    /// Posts a side at a mip: ceil((N - 1) / 2^m) + 1.
    int64_t columnsAt(int mip) const { return ceilShift(columns - 1, mip) + 1; }
    int64_t rowsAt(int mip) const { return ceilShift(rows - 1, mip) + 1; }
    /// Tiles a side at a mip.
    int tilesX(int mip) const {
        return static_cast<int>(ceilShift(columnsAt(mip) - 1, kTileCellsLog2));
    }
    int tilesY(int mip) const {
        return static_cast<int>(ceilShift(rowsAt(mip) - 1, kTileCellsLog2));
    }
    /// Number of mips: the coarsest is one tile.
    int mipCount() const {
        int mip = 0;
        while (tilesX(mip) > 1 || tilesY(mip) > 1) ++mip;
        return mip + 1;
    }
    /// Cells of a tile inside its mip, 1..512 a side.
    int cellsX(TileId id) const { return cellsLeft(columnsAt(id.mip) - 1, id.x); }
    int cellsY(TileId id) const { return cellsLeft(rowsAt(id.mip) - 1, id.y); }
    int64_t tileCount(int mip) const { return static_cast<int64_t>(tilesX(mip)) * tilesY(mip); }

private:
    static int cellsLeft(int64_t cells, int tile) {
        const int64_t left = cells - int64_t{tile} * kTileCells;
        return static_cast<int>(left < kTileCells ? left : kTileCells);
    }
    static int64_t ceilShift(int64_t value, int shift) {
        return (value + (int64_t{1} << shift) - 1) >> shift;
    }
};

}  // namespace terray
