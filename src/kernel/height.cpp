// SPDX-License-Identifier: Apache-2.0
// Heights of the drawn surface at places: the directory is walked from its coarsest square down.
#include "kernel/height.h"

#include <algorithm>

namespace terray {
namespace {

/// Posts of a cell of a tile, as a SurfaceCell without a place.
SurfaceCell cellOf(const TerrainCut& cut, uint32_t slot, int x, int y) {
    const TileDesc& tile = cut.tiles[slot];
    SurfaceCell cell;
    cell.slot = slot;
    cell.mip = static_cast<int>(tile.mipFlags & kTileMipMask);
    cell.x = x;
    cell.y = y;
    cell.h00 = postHeight(cut, tile, x, y);
    cell.h10 = postHeight(cut, tile, x + 1, y);
    cell.h01 = postHeight(cut, tile, x, y + 1);
    cell.h11 = postHeight(cut, tile, x + 1, y + 1);
    return cell;
}

bool isHole(const SurfaceCell& cell) {
    return std::isnan(cell.h00) || std::isnan(cell.h10) || std::isnan(cell.h01) ||
           std::isnan(cell.h11);
}

/// Cell in a tile and the place in it, from the lattice offset to the tile's first post.
int splitPlace(double offset, double cellSize, double& fraction) {
    const double place = offset / cellSize;
    const int cell = std::clamp(static_cast<int>(std::floor(place)), 0, 511);
    fraction = std::clamp(place - cell, 0.0, 1.0);
    return cell;
}

}  // namespace

uint32_t drawnSlotAt(const TerrainCut& cut, int64_t column, int64_t row) {
    for (int level = cut.rootLevel; level >= 0; --level) {
        const DirectoryLevel& grid = cut.levels[level];
        const auto x = static_cast<uint64_t>(column >> (9 + level));
        const auto y = static_cast<uint64_t>(row >> (9 + level));
        const Square& square = cut.squares[grid.offset + y * grid.columns + x];
        if (square.state == kSquareDrawn) return square.slot;
        if (square.state != kSquareDescend) return kNoSlot;
    }
    return kNoSlot;
}

double SurfaceCell::height(SurfaceKind surface) const {
    if (surface == kSurfaceConstant) {
        const bool right = u >= 0.5, lower = v >= 0.5;
        const float post = lower ? (right ? h11 : h01) : (right ? h10 : h00);
        return static_cast<double>(post);
    }
    const double a = h00, b = h10, c = h01, d = h11;
    if (surface == kSurfaceTriangles)
        return u + v <= 1 ? a + u * (b - a) + v * (c - a)
                          : d + (1 - u) * (c - d) + (1 - v) * (b - d);
    const double top = a + u * (b - a), bottom = c + u * (d - c);
    return top + v * (bottom - top);
}

SurfaceCell surfaceCellAt(const TerrainCut& cut, double i, double j) {
    const SurfaceCell none;
    if (!(i >= 0 && j >= 0 && i <= cut.cellsX && j <= cut.cellsY)) return none;
    const int64_t column = std::min<int64_t>(static_cast<int64_t>(i), cut.cellsX - 1);
    const int64_t row = std::min<int64_t>(static_cast<int64_t>(j), cut.cellsY - 1);
    const uint32_t slot = drawnSlotAt(cut, column, row);
    if (slot == kNoSlot) return none;
    const TileDesc& tile = cut.tiles[slot];
    const auto size = static_cast<double>(1u << (tile.mipFlags & kTileMipMask));
    double u = 0, v = 0;
    const int x = splitPlace(i - tile.x, size, u);
    const int y = splitPlace(j - tile.y, size, v);
    SurfaceCell cell = cellOf(cut, slot, x, y);
    if (isHole(cell)) return none;
    cell.u = u;
    cell.v = v;
    return cell;
}

double hitHeight(const TerrainCut& cut, const Hit& hit) {
    SurfaceCell cell =
        cellOf(cut, hit.tile, static_cast<int>(cellX(hit)), static_cast<int>(cellY(hit)));
    cell.u = static_cast<double>(hit.u);
    cell.v = static_cast<double>(hit.v);
    return cell.height(cut.surface);
}

}  // namespace terray
