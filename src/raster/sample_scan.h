// SPDX-License-Identifier: Apache-2.0
// One pass over all samples of a raster: range and holes, on all cores, in bounded memory.
#pragma once

#include <cstdint>

#include "base/result.h"
#include "raster/raster_header.h"

namespace terray {

struct SampleRange {
    double rawMin = 0, rawMax = 0;  ///< valid if hasRange
    int64_t holes = 0;
    bool hasRange = false;
};

Result<SampleRange> scanSamples(const RasterHeader& header);

}  // namespace terray
