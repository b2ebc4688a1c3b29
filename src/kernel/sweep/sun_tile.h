// SPDX-License-Identifier: Apache-2.0
// The sun sweep of one tile: from the bounds on its sunward borders to the entries of all its rows,
// and to the bounds on the borders that it hands on.
#pragma once

#include <array>
#include <cstdint>

#include "kernel/layout/layout.h"
#include "kernel/sweep/sun.h"

namespace terray {

/// Bounds of the shadow height on one border of a tile, per cell of the border.
struct BorderBounds {
    std::array<float, kSlotCells> free, caught;
};

/// What enters a tile from the sun's side: through its far row, and through its far column.
struct TileInflow {
    BorderBounds far, side;
};
/// What it hands on: at row 0, and at column 0.
struct TileOutflow {
    BorderBounds near, side;
};

/// A drawn tile and how it lies to the sun. Columns and rows are the sun's axes.
struct TileToSweep {
    const TileDesc* desc = nullptr;
    double columnsEnd = kSlotCells, rowsEnd = kSlotCells;  ///< the terrain's rim, if it is nearer
    int firstColumn = 0, lastColumn = kSlotCells;          ///< posts that exist
    int firstRow = 0, lastRow = kSlotCells;
    double drop = 0, dropPerColumn = 0, dropPerRow = 0;  ///< of a ray from row 1 to row 0, column 0
    double slack = 0;                                    ///< error of a drop
    double arc = 0;                                      ///< bend t^2 of a ray from row to row
};

/// Heights in the sweep, and how they become codes.
struct HeightScale {
    float anchorZ = 0, codeZ = 0, codesPerMetre = 1;
    float reach = 1;  ///< largest height relative to the anchor
};

void sweepTile(const TerrainCut& cut, const SunAxes& axes, const HeightScale& scale,
               const TileToSweep& tile, const TileInflow& inflow, TileOutflow& outflow,
               uint32_t* entries);

}  // namespace terray
