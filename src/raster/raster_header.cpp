// SPDX-License-Identifier: Apache-2.0
// Opening rasters over GDAL and reading what their header says about heights.
#include "raster/raster_header.h"

#include <cpl_string.h>
#include <cpl_vsi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "base/stopwatch.h"
#include "dataset/remote.h"
#include "raster/georeference.h"

namespace terray {
namespace {

constexpr int64_t kMaxSamples = int64_t{1} << 40;         // 10^12: beyond it a header is absurd
constexpr int64_t kMaxSamplesPerByte = int64_t{1} << 20;  // a sparse GeoTIFF has up to 2^16

std::string metadata(GDALMajorObject& object, const char* key, const char* domain = "") {
    const char* value = object.GetMetadataItem(key, domain);
    return value ? value : "";
}

DatasetHandle openDataset(const std::string& gdalName) {
    return DatasetHandle(GDALDataset::Open(gdalName.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                           nullptr, nullptr, nullptr));
}

/// Why a name could not be opened, as one sentence.
Error openError(const std::string& name) {
    VSIStatBufL status;
    const bool exists = VSIStatL(gdalName(name).c_str(), &status) == 0;
    if (exists && VSI_ISDIR(status.st_mode)) {
        return makeError(ErrorCode::Input, "'{}' is a folder, not a raster; name a file in it",
                         name);
    }
    if (!exists && name.find(':') == std::string::npos && !name.starts_with("/vsi")) {
        return makeError(ErrorCode::Input, "'{}' does not exist; check the path", name);
    }
    const std::string reason = gdalMessage();
    return makeError(ErrorCode::Input,
                     "'{}' cannot be opened as a raster ({}); check it with gdalinfo", name,
                     reason.empty() ? "GDAL knows no such format" : reason);
}

/// The subdatasets of a container: their GDAL names.
std::vector<std::string> subdatasets(GDALDataset& dataset) {
    std::vector<std::string> names;
    char** list = dataset.GetMetadata("SUBDATASETS");
    for (int i = 1;; ++i) {
        const char* name = CSLFetchNameValue(list, fmt::format("SUBDATASET_{}_NAME", i).c_str());
        if (name == nullptr) return names;
        names.emplace_back(name);
    }
}

std::string joinFirst(const std::vector<std::string>& names, size_t most) {
    std::string text;
    for (size_t i = 0; i < std::min(names.size(), most); ++i) {
        text += (i == 0 ? "" : ", ") + names[i];
    }
    return names.size() > most ? fmt::format("{} and {} more", text, names.size() - most) : text;
}

/// Formats whose samples lie in the named file itself, so that its size bounds their number.
bool holdsItsSamples(const std::string& driver) {
    constexpr std::string_view kDrivers[] = {"GTiff", "COG", "AAIGrid", "GRASSASCIIGrid",
                                             "GSAG",  "XYZ", "PNG",     "BMP"};
    return std::find(std::begin(kDrivers), std::end(kDrivers), driver) != std::end(kDrivers);
}

Result<void> checkSize(const RasterHeader& header, uint64_t budget) {
    const std::string& name = header.name;
    if (header.columns < 2 || header.rows < 2) {
        return makeError(ErrorCode::Input,
                         "'{}' is {} x {} samples; a terrain needs at least 2 x 2", name,
                         header.columns, header.rows);
    }
    const int64_t samples = header.columns * header.rows;  // each below 2^31
    VSIStatBufL status;
    const bool isFile = VSIStatL(header.gdalName.c_str(), &status) == 0 &&
                        VSI_ISREG(status.st_mode) && status.st_size > 0;
    const bool isLie = isFile && holdsItsSamples(header.driver) &&
                       samples / kMaxSamplesPerByte > static_cast<int64_t>(status.st_size);
    if (samples > kMaxSamples || isLie) {
        return makeError(ErrorCode::Input,
                         "'{}' claims {} x {} samples, which cannot be true{}; the file is damaged",
                         name, header.columns, header.rows,
                         isLie ? fmt::format(" of its {} bytes", status.st_size) : "");
    }
    const uint64_t blockSamples =
        static_cast<uint64_t>(header.blockColumns) * static_cast<uint64_t>(header.blockRows);
    if (blockSamples * 8 > std::max<uint64_t>(budget, 1u << 20)) {
        return makeError(ErrorCode::Input,
                         "'{}' has blocks of {} x {} samples, too large for the memory budget; "
                         "tile it first (gdal_translate -co TILED=YES)",
                         name, header.blockColumns, header.blockRows);
    }
    return {};
}

Result<void> checkBand(const std::string& name, GDALDataset& dataset, int band) {
    if (band >= 1 && band <= dataset.GetRasterCount()) return {};
    return makeError(ErrorCode::Usage, "--band {}: '{}' has bands 1 to {}", band, name,
                     dataset.GetRasterCount());
}

const char* encodingName(HeightEncoding encoding) {
    return encoding == HeightEncoding::Terrarium ? "terrarium" : "terrain-rgb";
}

Result<void> checkEncoding(const std::string& name, GDALDataset& dataset, HeightEncoding encoding) {
    bool fits = dataset.GetRasterCount() >= 3;
    for (int band = 1; fits && band <= 3; ++band) {
        fits = dataset.GetRasterBand(band)->GetRasterDataType() == GDT_Byte;
    }
    if (fits) return {};
    return makeError(ErrorCode::Usage,
                     "--encoding {}: '{}' has not the three 8-bit bands (red, green, blue) that "
                     "such heights are kept in",
                     encodingName(encoding), name);
}

Result<void> describeType(GDALRasterBand& band, RasterHeader& header) {
    const GDALDataType type = band.GetRasterDataType();
    SampleRules& rules = header.rules;
    header.sampleType = GDALGetDataTypeName(type);
    if (GDALDataTypeIsComplex(type)) {
        return makeError(ErrorCode::Input,
                         "'{}' holds complex numbers ({}), which are no heights; take a part with "
                         "gdal_translate or gdal_calc",
                         header.name, header.sampleType);
    }
    if (band.GetColorTable() != nullptr && rules.encoding == HeightEncoding::None) {
        return makeError(ErrorCode::Input,
                         "'{}' holds palette indices (colours), not heights; give a DEM, or "
                         "another --band",
                         header.name);
    }
    const int bits = GDALGetDataTypeSizeBits(type);
    rules.integer = GDALDataTypeIsInteger(type) && rules.encoding == HeightEncoding::None;
    rules.signedByte =
        type == GDT_Byte && metadata(band, "PIXELTYPE", "IMAGE_STRUCTURE") == "SIGNEDBYTE";
    if (rules.signedByte) header.sampleType = "Int8";
    rules.wide = bits > 32 || (bits == 32 && rules.integer);
    if (rules.integer) {
        const bool isSigned = rules.signedByte || GDALDataTypeIsSigned(type);
        header.typeMin = isSigned ? -std::ldexp(1.0, bits - 1) : 0;
        header.typeMax = std::ldexp(1.0, isSigned ? bits - 1 : bits) - 1;
    }
    return {};
}

std::optional<double> declaredNodata(GDALRasterBand& band) {
    int has = 0;
    double value = 0;
    if (band.GetRasterDataType() == GDT_Int64) {
        value = static_cast<double>(band.GetNoDataValueAsInt64(&has));
    } else if (band.GetRasterDataType() == GDT_UInt64) {
        value = static_cast<double>(band.GetNoDataValueAsUInt64(&has));
    } else {
        value = band.GetNoDataValue(&has);
    }
    return has ? std::optional(value) : std::nullopt;
}

/// A value "slightly above float max", as text round trips leave it, means float max itself.
double nearestFloat(double value) {
    constexpr double kMax = std::numeric_limits<float>::max();
    const bool isSlip = std::abs(value) > kMax && std::abs(value) < kMax * 1.000001;
    return isSlip ? std::copysign(kMax, value) : value;
}

void describeNodata(GDALRasterBand& band, std::optional<double> given, RasterHeader& header) {
    SampleRules& rules = header.rules;
    const bool encoded = rules.encoding != HeightEncoding::None;
    if (given || !encoded) rules.nodata = given ? given : declaredNodata(band);
    if (rules.nodata && rules.signedByte && *rules.nodata > 127) *rules.nodata -= 256;
    if (rules.nodata && header.sampleType == "Float32") rules.nodata = nearestFloat(*rules.nodata);
    std::string rule;
    if (rules.nodata) {
        rule = std::isnan(*rules.nodata) ? "NaN" : fmt::format("value {}", *rules.nodata);
        if (given) rule += " (--nodata)";
    }
    const int flags = band.GetMaskFlags();
    const bool byValue = (flags & GMF_NODATA) != 0 && (flags & GMF_PER_DATASET) == 0;
    rules.useMask = (flags & GMF_ALL_VALID) == 0 && !byValue;
    if (rules.useMask) {
        if (!rule.empty()) rule += ", ";
        rule += (flags & GMF_ALPHA) != 0 ? "alpha band" : "mask band";
    }
    header.nodataRule = rule.empty() ? "none" : rule;
}

Result<void> describeScale(GDALRasterBand& band, RasterHeader& header) {
    SampleRules& rules = header.rules;
    int hasScale = 0, hasOffset = 0;
    const double scale = band.GetScale(&hasScale), offset = band.GetOffset(&hasOffset);
    if (hasScale) rules.scale = scale;
    if (hasOffset) rules.offset = offset;
    if (rules.scale == 0 || !std::isfinite(rules.scale) || !std::isfinite(rules.offset)) {
        return makeError(ErrorCode::Input,
                         "'{}' declares the scale {} and the offset {} for its heights, which "
                         "make no heights; set them with gdal_translate -a_scale -a_offset",
                         header.name, rules.scale, rules.offset);
    }
    return {};
}

/// Heights of the middle of a picture under an encoding: do they look like a terrain?
bool looksEncoded(GDALDataset& dataset, HeightEncoding encoding) {
    const int width = std::min(64, dataset.GetRasterXSize());
    const int height = std::min(16, dataset.GetRasterYSize());
    const auto count = static_cast<size_t>(width) * static_cast<size_t>(height);
    std::vector<uint8_t> rgb(count * 3);
    int bands[3] = {1, 2, 3};
    if (dataset.RasterIO(GF_Read, (dataset.GetRasterXSize() - width) / 2,
                         (dataset.GetRasterYSize() - height) / 2, width, height, rgb.data(), width,
                         height, GDT_Byte, 3, bands, 3, 3 * width, 1, nullptr) != CE_None) {
        return false;
    }
    double lowest = HUGE_VAL, highest = -HUGE_VAL;
    for (size_t k = 0; k < count; ++k) {
        const double z =
            encoding == HeightEncoding::Terrarium
                ? rgb[3 * k] * 256.0 + rgb[3 * k + 1] + rgb[3 * k + 2] / 256.0 - 32768
                : -10000 + 0.1 * (rgb[3 * k] * 65536.0 + rgb[3 * k + 1] * 256.0 + rgb[3 * k + 2]);
        lowest = std::min(lowest, z);
        highest = std::max(highest, z);
    }
    return lowest >= -500 && highest <= 9000 && highest > lowest && highest - lowest < 4000;
}

/// A colour picture taken for heights is an assumption to be told, with the flag that may help.
void noteColourPicture(GDALDataset& dataset, RasterHeader& header) {
    if (header.rules.encoding != HeightEncoding::None || dataset.GetRasterCount() < 3) return;
    for (int band = 1; band <= 3; ++band) {
        if (dataset.GetRasterBand(band)->GetRasterDataType() != GDT_Byte) return;
    }
    std::string advice = "give a DEM, or --encoding if it encodes heights";
    if (looksEncoded(dataset, HeightEncoding::TerrainRgb)) {
        advice = "it looks like encoded heights: decode them with --encoding terrain-rgb";
    } else if (looksEncoded(dataset, HeightEncoding::Terrarium)) {
        advice = "it looks like encoded heights: decode them with --encoding terrarium";
    }
    header.assumptions.push_back(
        {fmt::format("'{}' is a colour picture; its band {} is taken as heights ({})", header.name,
                     header.rules.band, advice),
         true});
}

}  // namespace

Result<OpenedRaster> openRaster(const std::string& name) {
    ensureGdal();
    clearGdalMessage();
    const std::string path = gdalName(name);
    OpenedRaster opened{openDataset(path), path};
    if (!opened.dataset) return openError(name);
    if (opened.dataset->GetRasterCount() > 0) return opened;
    const std::vector<std::string> parts = subdatasets(*opened.dataset);
    if (parts.empty()) {
        return makeError(ErrorCode::Input, "'{}' holds no raster band; give a DEM", name);
    }
    if (parts.size() > 1) {
        return makeError(ErrorCode::Input, "'{}' holds {} rasters; name one of them: {}", name,
                         parts.size(), joinFirst(parts, 12));
    }
    opened = {openDataset(parts.front()), parts.front()};
    if (!opened.dataset || opened.dataset->GetRasterCount() == 0) return openError(parts.front());
    return opened;
}

uint64_t memoryBudget(uint64_t memoryBytes) {
    if (memoryBytes != 0) return memoryBytes;
    return std::min<uint64_t>(uint64_t{2} << 30, physicalMemoryBytes() / 2);
}

Result<RasterHeader> readHeader(const std::string& name, const OpenOptions& options) {
    Result<OpenedRaster> opened = openRaster(name);
    if (!opened) return opened.error();
    GDALDataset& dataset = *opened->dataset;
    TERRAY_TRY(checkBand(name, dataset, options.band));
    if (options.encoding != HeightEncoding::None) {
        TERRAY_TRY(checkEncoding(name, dataset, options.encoding));
    }
    RasterHeader header;
    header.name = shownName(name);
    header.gdalName = opened->gdalName;
    header.driver = dataset.GetDriverName();
    header.columns = dataset.GetRasterXSize();
    header.rows = dataset.GetRasterYSize();
    header.bands = dataset.GetRasterCount();
    header.rules.encoding = options.encoding;
    header.rules.band = options.encoding == HeightEncoding::None ? options.band : 1;
    GDALRasterBand& band = *dataset.GetRasterBand(header.rules.band);
    band.GetBlockSize(&header.blockColumns, &header.blockRows);
    TERRAY_TRY(checkSize(header, memoryBudget(options.memoryBytes)));
    TERRAY_TRY(describeType(band, header));
    describeNodata(band, options.nodata, header);
    if (options.encoding == HeightEncoding::None) {
        TERRAY_TRY(describeScale(band, header));
        header.unitType = band.GetUnitType();
    } else {
        header.unitType = "m";
    }
    header.pixelIsPoint = metadata(dataset, "AREA_OR_POINT") == "Point";
    TERRAY_TRY(readGeoreference(dataset, header));
    noteColourPicture(dataset, header);
    return header;
}

}  // namespace terray
