// SPDX-License-Identifier: Apache-2.0
// Where a raster lies: its geotransform or ground control points, and its CRS.
#pragma once

#include "base/result.h"
#include "raster/raster_header.h"

namespace terray {

/// Fills transform, crsWkt and what had to be assumed. Error: Input (a transform without an area).
Result<void> readGeoreference(GDALDataset& dataset, RasterHeader& header);

}  // namespace terray
