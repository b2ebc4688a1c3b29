// SPDX-License-Identifier: Apache-2.0
// Photos in: any raster with colour, warped to the working CRS, as 8-bit RGBA.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "math/affine.h"
#include "terray/options.h"

namespace terray {

/// Straight-alpha sRGB, row-major, 4 bytes a pixel. Pixel (i, j)'s centre is at lattice place (i,
/// j) of worldFromPixel. Alpha 0: the photo does not cover that place.
struct Photo {
    int width = 0, height = 0;
    std::vector<uint8_t> rgba;
    Affine2 worldFromPixel;
    std::string description;  ///< one line for the output: size, bands used, stretch
};

/// Reads the part of a photo over a world rectangle (metres), warped to the working CRS if its own
/// differs, at its own resolution or coarser so that it stays within `maxBytes` (said in a note).
/// A photo with coordinates but no CRS is taken to be in `dataCrsWkt` (the DEM's; empty: the
/// working CRS); one without any georeference is stretched over the DEM's extent, with a note. A
/// photo that does not touch the rectangle is an error (Input).
Result<Photo> loadPhoto(const std::string& path, const OpenOptions& options,
                        const std::string& workingCrsWkt, double metresPerCrsUnit, Vec2 worldMin,
                        Vec2 worldMax, uint64_t maxBytes, const std::string& dataCrsWkt = {});

}  // namespace terray
