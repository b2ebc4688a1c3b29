// SPDX-License-Identifier: Apache-2.0
// VRTs that bind the height files of a mip into one raster, for QGIS and GDAL.
#pragma once

#include <string>

#include "base/result.h"
#include "store/in_place.h"
#include "store/photo_layer.h"
#include "tile/terrain_info.h"

namespace terray {

/// height.vrt for mip 0, with the coarser mips as overviews; height/mN.vrt for mip N.
/// Mip 0 may be a source in place.
Result<std::string> vrtText(const TerrainInfo& info, int mip,
                            const std::optional<InPlaceSource>& inPlace = std::nullopt);
/// photo.vrt for mip 0 of the photo, likewise; photo/mN.vrt for mip N.
Result<std::string> photoVrtText(const TerrainInfo& info, const PhotoLayer& layer, int mip);

/// The dataset's first lines: size, CRS, geotransform. Closed by </VRTDataset>.
Result<std::string> vrtHead(const TerrainInfo& info, const BlockGrid& grid,
                            const GeoTransform& transform);

}  // namespace terray
