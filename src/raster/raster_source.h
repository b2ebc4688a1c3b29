// SPDX-License-Identifier: Apache-2.0
// HeightSources over a raster: its own samples as posts, or posts of a warped lattice.
#pragma once

#include <memory>
#include <optional>

#include "raster/post_codes.h"
#include "raster/raster_header.h"
#include "raster/warp.h"
#include "tile/height_source.h"

namespace terray {

/// The samples are the posts. With codes, info's format is Int16 and heights are decoded codes.
std::unique_ptr<HeightSource> makeRasterSource(TerrainInfo info, RasterHeader header,
                                               std::optional<PostCodes> codes);
std::unique_ptr<HeightSource> makeWarpedSource(TerrainInfo info, WarpPlan plan);

}  // namespace terray
