// SPDX-License-Identifier: Apache-2.0
// What follows from the posts of a slot, for rays to walk: its pyramid and its sharpness.
#pragma once

#include "stream/pool.h"

namespace terray {

/// Pyramid, slot bounds and the tile's decoding of bounds. Touches nothing of other slots.
void makePyramid(ResidentTerrain::Pool& pool, uint32_t slot);

/// Sharpness, which at the rim follows from the neighbours' posts too: those that are resident.
/// Where one is not, the rim's holds only as long as that neighbour is not drawn beside this tile.
void makeSharpness(ResidentTerrain::Pool& pool, uint32_t slot);

}  // namespace terray
