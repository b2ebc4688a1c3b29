// SPDX-License-Identifier: Apache-2.0
// Several DEMs of unlike CRSs, lattices, types and units as one terrain: each is warped on the fly.
#pragma once

#include <span>
#include <string>

#include "raster/dem.h"

namespace terray {

/// Posts are floats on a north-up lattice in the working CRS (chosen for the joint extent, by the
/// first DEM's), as far apart as the finest DEM's ground size and aligned to it. Where several have
/// a height, the last named one counts; between them are holes. Errors: Input, Usage, naming the
/// DEM.
Result<Dem> openUnlikeDems(std::span<const std::string> names, const OpenOptions& options);

}  // namespace terray
