// SPDX-License-Identifier: Apache-2.0
// loadPhoto: the planned pixels, read or warped at once.
#include "raster/photo.h"

#include <cpl_conv.h>

#include <algorithm>

#include "raster/photo_plan.h"
#include "raster/photo_resample.h"
#include "raster/source_map.h"

namespace terray {
namespace {

Result<void> fillWarped(const PhotoPlan& plan, PhotoPixels& pixels, Photo& photo) {
    const PhotoWindow& window = plan.window;
    std::vector<uint8_t> source(static_cast<size_t>(window.outWidth) *
                                static_cast<size_t>(window.outHeight) * 4);
    TERRAY_TRY(pixels.read(window, source.data()));
    const Result<SourceMap> map = SourceMap::make(*plan.warp);
    if (!map) return map.error();
    resamplePhoto({source.data(), window.outWidth, window.outHeight, window.outWidth}, *map, photo);
    return {};
}

}  // namespace

Result<Photo> loadPhoto(const std::string& path, const OpenOptions& options,
                        const std::string& workingCrsWkt, double metresPerCrsUnit, Vec2 worldMin,
                        Vec2 worldMax, uint64_t maxBytes, const std::string& dataCrsWkt) {
    ensureGdal();
    // for this thread and call: decode on all cores, and copy uncompressed GeoTIFFs past the cache
    const CPLConfigOptionSetter allCores("GDAL_NUM_THREADS", "ALL_CPUS", true);
    const CPLConfigOptionSetter pastTheCache("GTIFF_DIRECT_IO", "YES", true);
    Result<PhotoPlan> plan = openPhoto(path);
    if (!plan) return plan.error();
    Result<PhotoPixels> pixels = PhotoPixels::make(*plan->dataset, path, options);
    if (!pixels) return pixels.error();
    TERRAY_TRY(planPhoto({workingCrsWkt, metresPerCrsUnit, worldMin, worldMax,
                          std::max<uint64_t>(maxBytes, 4096), dataCrsWkt},
                         *plan));
    Photo photo;
    photo.width = plan->columns;
    photo.height = plan->rows;
    photo.worldFromPixel = plan->worldFromPixel;
    photo.rgba.resize(static_cast<size_t>(photo.width) * static_cast<size_t>(photo.height) * 4);
    if (plan->warp) {
        TERRAY_TRY(fillWarped(*plan, *pixels, photo));
    } else {
        TERRAY_TRY(pixels->read(plan->window, photo.rgba.data()));
    }
    photo.description = plan->describe(*pixels);
    return photo;
}

}  // namespace terray
