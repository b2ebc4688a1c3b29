// SPDX-License-Identifier: Apache-2.0
// What is known of a DEM before it is decided how its posts are delivered. Inside this room only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geo/frame.h"
#include "math/affine.h"
#include "raster/raster_header.h"
#include "terray/terrain.h"
#include "tile/terrain_info.h"

namespace terray {

struct Description {
    RasterHeader header;
    std::optional<CrsFacts> crs;
    std::string heightUnit;
    Affine2 dataFromSample;  ///< sample (i, j) = pixel centre, in CRS units
    std::vector<Assumption> assumptions;
};

/// Reads the header; CRS and units as the file or the options say. Errors: Input, Usage.
Result<Description> describeDem(const std::string& path, const OpenOptions& options);

struct Extent2 {
    Vec2 min, max;
};
/// Of the outermost samples, in CRS units.
Extent2 extentOf(const RasterHeader& header, const Affine2& map);

SourceInfo factsOf(const Description& d);
/// Radius of curvature at the terrain's centre; 0 without a CRS.
Result<double> radiusAtCentre(const Description& d, const TerrainInfo& info);
/// The facts that follow from the lattice.
void finishFacts(const TerrainInfo& info, SourceInfo& facts);

}  // namespace terray
