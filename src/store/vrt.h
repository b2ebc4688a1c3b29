// SPDX-License-Identifier: Apache-2.0
// VRTs that bind the height files of a mip into one raster, for QGIS and GDAL.
#pragma once

#include <string>

#include "base/result.h"
#include "tile/terrain_info.h"

namespace terray {

/// height.vrt for mip 0, with the coarser mips as overviews; height/mN.vrt for mip N.
Result<std::string> vrtText(const TerrainInfo& info, int mip);

}  // namespace terray
