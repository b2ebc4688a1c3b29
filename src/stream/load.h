// SPDX-License-Identifier: Apache-2.0
// Mip 0 from its source into the slots of a pool.
#pragma once

#include "base/result.h"
#include "stream/pool.h"
#include "tile/tile_source.h"

namespace terray {

struct LoadSummary {
    uint64_t holes = 0;        ///< posts without a height
    float minZ = 0, maxZ = 0;  ///< of the others; 0 if there is none
};

/// Reads every post once, with a reader per core. Each source row goes straight into the tiles
/// that hold it; a post on a tile border goes into all of them.
Result<LoadSummary> loadFinest(const HeightSource& source, ResidentTerrain::Pool& pool);

/// Reads the tiles of all mips into their slots. All cores.
Result<void> loadTiles(const TileSource& source, ResidentTerrain::Pool& pool);

}  // namespace terray
