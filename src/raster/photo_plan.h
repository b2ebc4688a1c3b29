// SPDX-License-Identifier: Apache-2.0
// Which pixels of a photo lie over the terrain, and on which lattice they come.
#pragma once

#include <optional>
#include <string>

#include "raster/photo_pixels.h"
#include "raster/warp.h"

namespace terray {

/// Where a photo is wanted: what loadPhoto() takes.
struct PhotoPlace {
    std::string workingCrsWkt;
    double metresPerCrsUnit = 1;
    Vec2 worldMin, worldMax;
    uint64_t maxBytes = 0;
    std::string dataCrsWkt;
};

/// A photo opened, and how its pixels come onto their lattice.
struct PhotoPlan {
    std::string path;
    DatasetHandle dataset;
    RasterHeader header;            ///< name, transform, crsWkt only
    PhotoWindow window;             ///< of the file, perhaps reduced
    std::optional<WarpPlan> warp;   ///< from the window's samples; none: they are the pixels
    int columns = 0, rows = 0;      ///< of the lattice
    Affine2 worldFromPixel;         ///< pixel centres at whole lattice places
    double factor = 1;              ///< by which pixels are larger than the photo's own
    std::string how;                ///< it is placed, in words
    bool takesTerrainsCrs = false;  ///< it has coordinates but names no CRS

    /// "photo.tif: 20 x 10 pixels, bands 1, 2, 3, in the working CRS".
    std::string describe(const PhotoPixels& pixels) const;
};

/// Opens a photo. Error Input: unreadable, or placed by what is no plane map.
Result<PhotoPlan> openPhoto(const std::string& path);

/// Fills window and lattice. Error Input if the photo does not touch the rectangle.
Result<void> planPhoto(const PhotoPlace& place, PhotoPlan& plan);

}  // namespace terray
