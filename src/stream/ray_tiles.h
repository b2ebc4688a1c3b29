// SPDX-License-Identifier: Apache-2.0
// The tiles of mip 0 that a ray may meet, from the bounds of all mips alone.
#pragma once

#include <vector>

#include "stream/resident.h"

namespace terray {

struct RayTile {
    TileId id;
    double enter = 0;  ///< a distance along the ray before which it does not meet the tile
};

/// In the order in which the ray enters them. Never too few.
std::vector<RayTile> tilesAlong(const ResidentTerrain& terrain, const Ray& ray,
                                SurfaceKind surface);

}  // namespace terray
