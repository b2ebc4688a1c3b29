// SPDX-License-Identifier: Apache-2.0
// Whether DEMs lie on one lattice, and the VRT that joins them.
#include "raster/mosaic.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_utils.h>

#include <cmath>
#include <filesystem>

#include "dataset/gdal_handle.h"
#include "raster/raster_header.h"

namespace terray {
namespace {

constexpr double kSameSamples = 0.01;  ///< of a sample: places that are told apart

/// DEMs of one lattice and kind: nothing is resampled, and nothing is guessed.
bool areAlike(const RasterHeader& first, const RasterHeader& other) {
    if (!first.transform || !other.transform) return false;
    const std::array<double, 6>&a = *first.transform, &b = *other.transform;
    const double across = static_cast<double>(std::max(first.columns, other.columns));
    const double down = static_cast<double>(std::max(first.rows, other.rows));
    const bool straight = a[2] == 0 && a[4] == 0 && b[2] == 0 && b[4] == 0 && a[5] < 0;
    if (!straight || std::abs(a[1] - b[1]) * across > kSameSamples * a[1] ||
        std::abs(a[5] - b[5]) * down > kSameSamples * -a[5]) {
        return false;
    }
    const double i = (b[0] - a[0]) / a[1], j = (b[3] - a[3]) / a[5];
    if (std::abs(i - std::round(i)) > kSameSamples || std::abs(j - std::round(j)) > kSameSamples) {
        return false;
    }
    return first.crsWkt == other.crsWkt && first.sampleType == other.sampleType &&
           first.unitType == other.unitType && first.rules.scale == other.rules.scale &&
           first.rules.offset == other.rules.offset && !first.rules.useMask &&
           !other.rules.useMask && first.rules.nodata.has_value() == other.rules.nodata.has_value();
}

/// With a nodata value, that marks what no DEM covers; without one an alpha band does.
CPLStringList buildOptions(const RasterHeader& first, const OpenOptions& options) {
    CPLStringList list;
    const auto add = [&](const char* name, const std::string& value) {
        list.AddString(name);
        list.AddString(value.c_str());
    };
    add("-b", std::to_string(first.rules.band));
    if (options.nodata) {
        const std::string value = fmt::format("{}", *options.nodata);
        add("-srcnodata", value);
        add("-vrtnodata", value);
    } else if (!first.rules.nodata && !first.rules.integer) {
        add("-vrtnodata", "nan");
    } else if (!first.rules.nodata) {
        list.AddString("-addalpha");
    }
    return list;
}

}  // namespace

Result<std::unique_ptr<Mosaic>> Mosaic::join(std::span<const std::string> names,
                                             const OpenOptions& options) {
    if (options.encoding != HeightEncoding::None) return std::unique_ptr<Mosaic>();
    std::vector<RasterHeader> headers;
    CPLStringList files;  // of a VRT's sources the last one is on top
    for (const std::string& name : names) {
        auto header = readHeader(name, options);
        if (!header) return header.error();
        headers.push_back(std::move(*header));
        files.AddString(name.c_str());
    }
    for (const RasterHeader& header : headers) {
        if (!areAlike(headers.front(), header)) return std::unique_ptr<Mosaic>();
    }
    const std::string file = std::filesystem::path(names[0]).filename();
    std::unique_ptr<Mosaic> mosaic(new Mosaic(
        fmt::format("/vsimem/terray_mosaic/{}_and_{}_more.vrt", file, names.size() - 1)));
    clearGdalMessage();
    const CPLStringList list = buildOptions(headers.front(), options);
    const std::unique_ptr<GDALBuildVRTOptions, void (*)(GDALBuildVRTOptions*)> parsed(
        GDALBuildVRTOptionsNew(const_cast<char**>(list.List()), nullptr), GDALBuildVRTOptionsFree);
    int usageError = 0;
    const DatasetHandle dataset(
        GDALDataset::FromHandle(GDALBuildVRT(mosaic->path_.c_str(), static_cast<int>(names.size()),
                                             nullptr, files.List(), parsed.get(), &usageError)));
    if (!dataset || usageError != 0) {
        return makeError(ErrorCode::Input, "'{}' and {} more cannot be joined: {}", names[0],
                         names.size() - 1, gdalMessage());
    }
    return mosaic;
}

Mosaic::~Mosaic() { VSIUnlink(path_.c_str()); }

}  // namespace terray
