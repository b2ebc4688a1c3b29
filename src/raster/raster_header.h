// SPDX-License-Identifier: Apache-2.0
// What the header of a height raster says: size, samples, nodata, units, georeference. Opening and
// refusing happen here, before any sample is read.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "dataset/gdal_handle.h"
#include "terray/options.h"
#include "terray/terrain.h"

namespace terray {

/// How the numbers of the file become heights: (raw * scale + offset) * metresPerUnit. "Raw" is the
/// stored number; for terrain-RGB and Terrarium it is the decoded height in metres.
struct SampleRules {
    int band = 1;
    HeightEncoding encoding = HeightEncoding::None;
    bool signedByte = false;       ///< Byte band that holds int8 (GDAL before 3.7)
    bool integer = false;          ///< raw values are whole numbers
    bool wide = false;             ///< raw values need a double: 32-bit integers and above, float64
    std::optional<double> nodata;  ///< raw value that marks a hole; NaN and infinity always do
    bool useMask = false;          ///< GDAL's mask (or alpha) band marks holes with 0
    double scale = 1, offset = 0;
    double metresPerUnit = 1;

    double metres(double raw) const { return (raw * scale + offset) * metresPerUnit; }
    bool isIdentity() const { return scale == 1 && offset == 0 && metresPerUnit == 1; }
};

struct RasterHeader {
    std::string name;      ///< as the user wrote it
    std::string gdalName;  ///< what GDAL opens: the file or its one subdataset
    std::string driver;
    int64_t columns = 0, rows = 0;
    int bands = 0;
    int blockColumns = 0, blockRows = 0;
    std::string sampleType;
    double typeMin = 0, typeMax = 0;  ///< smallest and largest raw value of integer types
    std::optional<std::array<double, 6>> transform;  ///< of pixel corners, as GDAL
    bool pixelIsPoint = false;
    std::string crsWkt;    ///< WKT2; empty if none
    std::string unitType;  ///< of the heights as the band says; empty if it does not
    std::string nodataRule;
    SampleRules rules;  ///< metresPerUnit is still 1
    std::vector<Assumption> assumptions;
};

/// Opens a dataset for reading; the one subdataset if it has no bands itself. Error: Input.
struct OpenedRaster {
    DatasetHandle dataset;
    std::string gdalName;
};
Result<OpenedRaster> openRaster(const std::string& name);

/// Memory that one terrain may take: --memory, or the smaller of 2 GiB and half of the RAM.
uint64_t memoryBudget(uint64_t memoryBytes);

/// Reads and checks the header. Errors: Input, Usage (band, encoding).
Result<RasterHeader> readHeader(const std::string& name, const OpenOptions& options);

}  // namespace terray
