// SPDX-License-Identifier: Apache-2.0
// All that follows from the posts of mip 0: coarser posts, pyramids, errors.
#pragma once

#include "base/result.h"
#include "stream/pool.h"
#include "tile/tile_source.h"

namespace terray {

/// Fills the slots of mips 1.., the pyramids of all slots and the block bounds. All cores.
Result<void> buildMips(ResidentTerrain::Pool& pool);

/// The same for tiles that are all loaded, from a source that knows their errors.
Result<void> takeMips(const TileSource& source, ResidentTerrain::Pool& pool);

}  // namespace terray
