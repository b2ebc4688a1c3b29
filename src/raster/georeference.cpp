// SPDX-License-Identifier: Apache-2.0
// Geotransform, ground control points and CRS of a GDAL dataset.
#include "raster/georeference.h"

#include <gdal_alg.h>
#include <ogr_spatialref.h>

#include <cmath>

namespace terray {
namespace {

std::string wktOf(const OGRSpatialReference* reference) {
    if (reference == nullptr || reference->IsEmpty()) return {};
    char* text = nullptr;
    const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
    std::string wkt;
    if (reference->exportToWkt(&text, options) == OGRERR_NONE && text != nullptr) wkt = text;
    CPLFree(text);
    return wkt;
}

/// The plane map through the ground control points, if they lie on one.
bool readControlPoints(GDALDataset& dataset, RasterHeader& header) {
    const int count = dataset.GetGCPCount();
    if (count == 0) return false;
    std::array<double, 6> transform{};
    if (GDALGCPsToGeoTransform(count, dataset.GetGCPs(), transform.data(), FALSE)) {
        header.transform = transform;
        header.crsWkt = wktOf(dataset.GetGCPSpatialRef());
        return true;
    }
    header.assumptions.push_back(
        {fmt::format("'{}' has {} ground control points that lie on no plane map; they are ignored "
                     "and its pixels are taken as metres (gdalwarp makes a map of them)",
                     header.name, count),
         true});
    return true;
}

}  // namespace

Result<void> readGeoreference(GDALDataset& dataset, RasterHeader& header) {
    std::array<double, 6> transform{};
    if (dataset.GetGeoTransform(transform.data()) == CE_None) {
        header.transform = transform;
        header.crsWkt = wktOf(dataset.GetSpatialRef());
    } else if (!readControlPoints(dataset, header)) {
        header.assumptions.push_back(
            {fmt::format("'{}' has no georeference; its pixels are taken as metres", header.name),
             true});
    }
    if (!header.transform) return {};
    const std::array<double, 6>& t = *header.transform;
    const double area = t[1] * t[5] - t[2] * t[4];
    bool isMap = std::isfinite(area) && area != 0;
    for (const double number : t) isMap = isMap && std::isfinite(number);
    if (isMap) return {};
    return makeError(ErrorCode::Input,
                     "'{}' has a geotransform without an area ({}, {}, {}, {}, {}, {}); set a "
                     "right one with gdal_edit -a_ullr",
                     header.name, t[0], t[1], t[2], t[3], t[4], t[5]);
}

}  // namespace terray
