// SPDX-License-Identifier: Apache-2.0
// What holds for GDAL while the store uses it, and names of files in memory.
#pragma once

#include <cpl_conv.h>
#include <gdal_priv.h>

#include <cstdint>
#include <string>

namespace terray {

/// While alive, this thread's GDAL writes and looks for no side-car files.
class GdalScope {
public:
    GdalScope();
    ~GdalScope();
    GdalScope(const GdalScope&) = delete;
    GdalScope& operator=(const GdalScope&) = delete;
};

/// A path below /vsimem/ that nobody else has.
std::string memoryFileName();

/// Bytes of a block of a GeoTIFF as they lie in the file; 0 if it has none.
uint64_t storedBlockBytes(GDALRasterBand& band, int x, int y);

}  // namespace terray
