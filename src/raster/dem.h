// SPDX-License-Identifier: Apache-2.0
// Opening DEMs over GDAL: types, nodata, units, encodings, orientation, warping. See docs/input.md.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "dataset/gdal_setup.h"
#include "terray/options.h"
#include "terray/terrain.h"
#include "tile/height_source.h"

namespace terray {

/// An opened DEM: a source of posts in the working CRS, and the facts about the file.
struct Dem {
    std::unique_ptr<HeightSource> source;
    SourceInfo facts;        ///< hasRange, holes: certain only after scanDem()
    std::string dataCrsWkt;  ///< of the file or --assign-crs; empty if none
    double heightStep = 0;   ///< metres from one whole number to the next; 0: posts are floats
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
