// SPDX-License-Identifier: Apache-2.0
// What a store says of its photo, and the names and sizes of its parts.
#pragma once

#include <string>

#include "math/affine.h"
#include "store/format.h"

namespace terray {

constexpr const char* kPhotoVrtName = "photo.vrt";
constexpr int kPhotoQuality = 90;  ///< of JPEG, unless said otherwise

/// A photo with the mips of a PhotoGrid (tile/photo_blocks.h).
struct PhotoLayer {
    int64_t columns = 0, rows = 0;
    Affine2 worldFromPixel;       ///< centre of pixel (i, j) of mip 0, metres
    int quality = kPhotoQuality;  ///< of JPEG, 1 to 100; 0: lossless
    std::string description;      ///< one line: bands, stretch, how it was placed

    bool isLossless() const { return quality == 0; }
    int mipCount() const;
    BlockGrid grid(int mip) const;
    /// Centres of a mip's pixels.
    Affine2 worldFromPixelOf(int mip) const;
    /// GDAL's six numbers for a raster that begins with pixel (column, row) of a mip.
    GeoTransform geoTransform(double metresPerCrsUnit, int mip, int64_t column, int64_t row) const;
};

/// Paths inside the store, with '/'.
std::string photoShardPath(ShardId shard);
std::string photoMipVrtPath(int mip);

}  // namespace terray
