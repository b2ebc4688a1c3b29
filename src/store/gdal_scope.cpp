// SPDX-License-Identifier: Apache-2.0
// Thread-local GDAL settings and file names in memory.
#include "store/gdal_scope.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdlib>

namespace terray {

GdalScope::GdalScope() {
    CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", "NO");
    CPLSetThreadLocalConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
}

GdalScope::~GdalScope() {
    CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", nullptr);
    CPLSetThreadLocalConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", nullptr);
}

uint64_t storedBlockBytes(GDALRasterBand& band, int x, int y) {
    const char* text = band.GetMetadataItem(fmt::format("BLOCK_SIZE_{}_{}", x, y).c_str(), "TIFF");
    return text ? std::strtoull(text, nullptr, 10) : 0;
}

std::string memoryFileName() {
    static std::atomic<uint64_t> next{0};
    return fmt::format("/vsimem/terray_store_{}.tif", next++);
}

}  // namespace terray
