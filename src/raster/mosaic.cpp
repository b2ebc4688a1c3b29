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

Error unlike(const RasterHeader& first, const RasterHeader& other, const std::string& what) {
    return makeError(ErrorCode::Input,
                     "'{}' {} than '{}': bring them onto one lattice first, for example with "
                     "gdalwarp -tap",
                     other.name, what, first.name);
}

/// DEMs of one lattice: nothing is resampled, and nothing is guessed.
Result<void> checkAlike(const RasterHeader& first, const RasterHeader& other) {
    if (!first.transform || !other.transform) {
        return makeError(ErrorCode::Input,
                         "'{}' has no georeference: several DEMs are joined by their places",
                         first.transform ? other.name : first.name);
    }
    const std::array<double, 6>&a = *first.transform, &b = *other.transform;
    const double across = static_cast<double>(std::max(first.columns, other.columns));
    const double down = static_cast<double>(std::max(first.rows, other.rows));
    const bool straight = a[2] == 0 && a[4] == 0 && b[2] == 0 && b[4] == 0 && a[5] < 0;
    if (!straight) return unlike(first, other, "is rotated or south-up, or has other axes");
    if (std::abs(a[1] - b[1]) * across > kSameSamples * a[1] ||
        std::abs(a[5] - b[5]) * down > kSameSamples * -a[5]) {
        return unlike(first, other, "has other pixels");
    }
    const double i = (b[0] - a[0]) / a[1], j = (b[3] - a[3]) / a[5];
    if (std::abs(i - std::round(i)) > kSameSamples || std::abs(j - std::round(j)) > kSameSamples) {
        return unlike(first, other, "has pixels at other places");
    }
    if (first.crsWkt != other.crsWkt) return unlike(first, other, "has another CRS");
    if (first.sampleType != other.sampleType)
        return unlike(first, other, "has another sample type");
    if (first.unitType != other.unitType || first.rules.scale != other.rules.scale ||
        first.rules.offset != other.rules.offset) {
        return unlike(first, other, "has another unit, scale or offset of heights");
    }
    if (first.rules.useMask || other.rules.useMask) {
        return makeError(ErrorCode::Input,
                         "'{}' marks holes by a mask: give it a nodata value first (gdal_translate "
                         "-a_nodata)",
                         first.rules.useMask ? first.name : other.name);
    }
    return {};
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
    if (options.encoding != HeightEncoding::None) {
        return makeError(ErrorCode::Usage,
                         "--encoding: give one DEM, or decode them first; colours are not joined");
    }
    std::vector<RasterHeader> headers;
    CPLStringList reversed;  // of a VRT's sources the last one is on top
    for (size_t k = names.size(); k-- > 0;) reversed.AddString(names[k].c_str());
    for (const std::string& name : names) {
        auto header = readHeader(name, options);
        if (!header) return header.error();
        if (!headers.empty()) TERRAY_TRY(checkAlike(headers.front(), *header));
        headers.push_back(std::move(*header));
        if (headers.front().rules.nodata.has_value() != headers.back().rules.nodata.has_value()) {
            return unlike(headers.front(), headers.back(), "marks holes in another way");
        }
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
                                             nullptr, reversed.List(), parsed.get(), &usageError)));
    if (!dataset || usageError != 0) {
        return makeError(ErrorCode::Input, "'{}' and {} more cannot be joined: {}", names[0],
                         names.size() - 1, gdalMessage());
    }
    return mosaic;
}

Mosaic::~Mosaic() { VSIUnlink(path_.c_str()); }

}  // namespace terray
