// SPDX-License-Identifier: Apache-2.0
// The memory budget: what --memory means, and what fits into it.
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"

namespace terray {

/// How a budget is shared out. Bytes.
struct MemoryPlan {
    uint64_t budget = 0;
    uint64_t gdalCache = 0;
    uint64_t frame = 0;  ///< bands of pixels, shading fields
    uint64_t photo = 0;  ///< what is left for a photo and its mips
};

/// `asked`: OpenOptions::memoryBytes, 0 for the default (the smaller of 2 GiB and half of the
/// RAM). Error Input when a terrain of `required` bytes does not fit; says how much it needs.
Result<MemoryPlan> planMemory(const std::string& source, uint64_t required, uint64_t asked,
                              uint64_t physical);

/// The same for a terrain whose tiles come and go: what of the budget they may take. `hasPhoto`: a
/// quarter is left to it.
struct StreamPlan {
    uint64_t tiles = 0, photo = 0;
};
StreamPlan planStreaming(bool hasPhoto, uint64_t asked, uint64_t physical);

/// True if a terrain of `required` bytes fits as a whole.
bool fitsWhole(uint64_t required, uint64_t asked, uint64_t physical);

/// The GDAL cache for a budget, known before a source is opened.
uint64_t gdalCacheBytes(uint64_t asked, uint64_t physical);

/// "1.5 GiB", "300 MiB", "12 KiB".
std::string bytesText(uint64_t bytes);

}  // namespace terray
