// SPDX-License-Identifier: Apache-2.0
// Builds a tile slot's (min, max) pyramid over cells from its posts; bounds are rounded outwards.
#pragma once

#include <cstdint>

#include "kernel/layout/layout.h"

namespace terray {

struct SlotBounds {
    float minZ, maxZ;    ///< of the valid cells; minZ > maxZ if there is none
    float maxDelta;      ///< largest |difference| of neighbouring posts of valid cells
    bool hasHoles;       ///< some cell inside the extent is a hole
    float sharpest = 0;  ///< largest finite sharpness, metres a cell
};

/// Fills `bounds` (kSlotBounds entries) for the cells [0, cellsX) x [0, cellsY) of the tile; the
/// others count as holes. Int16: codes pass through unchanged (boundsZ0 = z0, boundsStep = zStep).
/// Float32: quantises outwards and writes tile.boundsZ0 / boundsStep. Also sets tile.maxDelta.
SlotBounds buildPyramid(const uint16_t* posts, int cellsX, int cellsY, TileDesc& tile,
                        uint32_t* bounds);
SlotBounds buildPyramid(const float* posts, int cellsX, int cellsY, TileDesc& tile,
                        uint32_t* bounds);

/// Posts of the neighbouring tiles one step beyond a tile's rim; null where there are none.
template <class Post>
struct TileHalo {
    const Post *left = nullptr, *right = nullptr;  ///< one a row, cellsY + 1
    const Post *top = nullptr, *bottom = nullptr;  ///< one a column, cellsX + 1
};

/// Sharpness of a tile: kSlotSharpness codes, see layout.h. Around holes it is infinite: in every
/// cell that shares an edge with one. Returns the largest finite one of a block, metres a cell.
float buildSharpness(const uint16_t* posts, int cellsX, int cellsY, const TileHalo<uint16_t>& halo,
                     const TileDesc& tile, uint8_t* sharpness);
float buildSharpness(const float* posts, int cellsX, int cellsY, const TileHalo<float>& halo,
                     uint8_t* sharpness);

/// Sharpness code of a difference in metres, rounded up; 255 where it is infinite or no number.
uint8_t sharpnessCode(float metres);
/// The largest difference that the code may stand for.
float sharpnessOf(uint8_t code);

}  // namespace terray
