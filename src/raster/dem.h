// SPDX-License-Identifier: Apache-2.0
// Opening DEMs over GDAL: types, nodata, units, encodings, orientation, warping. See docs/input.md.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "dataset/gdal_setup.h"
#include "terray/options.h"
#include "terray/terrain.h"
#include "tile/height_source.h"

namespace terray {

/// A GeoTIFF whose samples lie as the blocks of a store do: one band in blocks of 512 x 512, north
/// up, in the working CRS, whole numbers of 16 bits or floats in metres.
struct PlainTiles {
    std::string path, sampleType;
    std::optional<double> nodata;
    int64_t base = 0;  ///< code = (sample - base) << shift, for whole numbers
    int shift = 0;
};

/// An opened DEM: a source of posts in the working CRS, and the facts about the file.
struct Dem {
    std::unique_ptr<HeightSource> source;
    SourceInfo facts;                      ///< hasRange, holes: certain only after scanDem()
    std::string dataCrsWkt;                ///< of the file or --assign-crs; empty if none
    std::optional<PlainTiles> plainTiles;  ///< none: `notPlain` says why
    std::string notPlain;
    double heightStep = 0;  ///< metres from one whole number to the next; 0: posts are floats
};

/// Which integer rasters are read once on opening, to know their range.
enum class RangeScan {
    IfResident,  ///< those that could fit into the memory budget
    Always,      ///< all: the terrain need not fit
};

/// Opens a DEM: reads the header (and auxiliary files) and, for integer samples that are not
/// warped, the samples once to know their range (then facts have it). Errors: Input, Usage,
/// Interrupted.
Result<Dem> openDem(const std::string& path, const OpenOptions& options,
                    RangeScan scan = RangeScan::IfResident);

/// Reads every sample of the file (not of the warped lattice) and fills the range and the number of
/// holes, unless openDem() already did.
Result<void> scanDem(const std::string& path, const OpenOptions& options, SourceInfo& facts);

}  // namespace terray
