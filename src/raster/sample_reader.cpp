// SPDX-License-Identifier: Apache-2.0
// Windows of samples by RasterIO, straight into the caller's array where the type allows it.
#include "raster/sample_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace terray {
namespace {

/// No height is that large. Rasters use such numbers as marks for nothing, declared or not: float
/// max, Surfer's 1.70141e38, netCDF's default fill 9.97e36.
constexpr double kNoHeight = 1e30;

template <class Raw>
constexpr Raw kHole = std::numeric_limits<Raw>::quiet_NaN();

/// Holes by value: nodata, infinities and absurd magnitudes become NaN.
template <class Raw>
void markHoles(std::span<Raw> raw, const SampleRules& rules) {
    const Raw limit = static_cast<Raw>(kNoHeight);
    double nodata = rules.nodata.value_or(HUGE_VAL);
    if (std::abs(nodata) > static_cast<double>(std::numeric_limits<Raw>::max())) nodata = HUGE_VAL;
    const auto mark = static_cast<Raw>(nodata);
    // text round trips leave float64 nodata values a few ulp off; float32 ones are exact
    const auto slack = std::is_same_v<Raw, double> && !rules.integer && std::isfinite(nodata)
                           ? static_cast<Raw>(std::abs(nodata) * 1e-15)
                           : Raw{0};
    for (Raw& value : raw) {
        const bool isHole = std::abs(value - mark) <= slack || !(std::abs(value) < limit);
        value = isHole ? kHole<Raw> : value;
    }
}

template <class Raw>
void signBytes(std::span<Raw> raw) {
    for (Raw& value : raw) value = value > 127 ? value - 256 : value;
}

/// Copies a dense part into its place in a window.
template <class From, class To, class Map>
void spread(const From* from, const SampleWindow& part, const SampleWindow& window, To* to,
            Map map) {
    for (int64_t j = 0; j < part.height; ++j) {
        const From* source = from + j * part.width;
        To* target =
            to + (part.row - window.row + j) * window.width + (part.column - window.column);
        for (int64_t i = 0; i < part.width; ++i) target[i] = map(source[i]);
    }
}

/// Nodata as a 16-bit type sees it; a value that cannot occur if it does not fit.
int integerNodata(const SampleRules& rules) {
    constexpr int kNever = std::numeric_limits<int>::min();
    if (!rules.nodata || std::abs(*rules.nodata) > 1e6) return kNever;
    const int value = static_cast<int>(*rules.nodata);
    return value == *rules.nodata ? value : kNever;
}

}  // namespace

Result<void> forEachPart(const SampleWindow& window, const RasterHeader& header, int64_t maxSamples,
                         const std::function<Result<void>(const SampleWindow&)>& use) {
    const int64_t blockRows = std::clamp<int64_t>(header.blockRows, 1, 1024);
    const int64_t blockColumns = std::max<int64_t>(header.blockColumns, 1);
    const int64_t rowsAtFullWidth = std::max<int64_t>(maxSamples / window.width, 1);
    const int64_t partRows = std::max(blockRows, rowsAtFullWidth / blockRows * blockRows);
    int64_t partColumns = window.width;
    if (partRows > rowsAtFullWidth) {
        const int64_t fitting = std::max<int64_t>(maxSamples / partRows, 1);
        partColumns = fitting >= blockColumns ? fitting / blockColumns * blockColumns : fitting;
    }
    const int64_t endRow = window.row + window.height, endColumn = window.column + window.width;
    for (int64_t row = window.row; row < endRow;) {
        const int64_t nextRow = std::min((row / blockRows * blockRows) + partRows, endRow);
        for (int64_t column = window.column; column < endColumn;) {
            const int64_t start = column >= blockColumns && partColumns >= blockColumns
                                      ? column / blockColumns * blockColumns
                                      : column;
            const int64_t nextColumn = std::min(start + partColumns, endColumn);
            TERRAY_TRY(use({column, row, nextColumn - column, nextRow - row}));
            column = nextColumn;
        }
        row = nextRow;
    }
    return {};
}

SampleReader::SampleReader(const RasterHeader& header, DatasetHandle dataset)
    : header_(header),
      dataset_(std::move(dataset)),
      band_(dataset_->GetRasterBand(header.rules.band)) {}

Result<std::unique_ptr<SampleReader>> SampleReader::open(const RasterHeader& header) {
    Result<OpenedRaster> opened = openRaster(header.gdalName);
    if (!opened) return opened.error();
    GDALDataset& dataset = *opened->dataset;
    if (dataset.GetRasterXSize() != header.columns || dataset.GetRasterYSize() != header.rows ||
        dataset.GetRasterCount() != header.bands) {
        return makeError(ErrorCode::Input, "'{}' changed while it was being read; try again",
                         header.name);
    }
    return std::unique_ptr<SampleReader>(new SampleReader(header, std::move(opened->dataset)));
}

Error SampleReader::readError(const SampleWindow& window) const {
    return makeError(ErrorCode::Input,
                     "'{}' cannot be read in rows {} to {} ({}); the file is damaged or incomplete",
                     header_.name, window.row, window.row + window.height - 1, gdalMessage());
}

Error SampleReader::changedError() const {
    return makeError(ErrorCode::Input,
                     "'{}' holds heights that were not there when it was opened; it changed while "
                     "it was being read, try again",
                     header_.name);
}

Result<void> SampleReader::fetch(GDALRasterBand& band, const SampleWindow& window,
                                 GDALDataType type, void* out) {
    clearGdalMessage();
    const auto width = static_cast<int>(window.width), height = static_cast<int>(window.height);
    if (band.RasterIO(GF_Read, static_cast<int>(window.column), static_cast<int>(window.row), width,
                      height, out, width, height, type, 0, 0, nullptr) != CE_None) {
        return readError(window);
    }
    return {};
}

template <class Raw>
Result<void> SampleReader::applyMask(const SampleWindow& window, std::span<Raw> raw) {
    if (!header_.rules.useMask) return {};
    return forEachPart(window, header_, kPartSamples,
                       [&](const SampleWindow& part) -> Result<void> {
                           bytes_.resize(part.size());
                           TERRAY_TRY(fetch(*band_->GetMaskBand(), part, GDT_Byte, bytes_.data()));
                           for (int64_t j = 0; j < part.height; ++j) {
                               const uint8_t* mask = bytes_.data() + j * part.width;
                               Raw* row = raw.data() + (part.row - window.row + j) * window.width +
                                          (part.column - window.column);
                               for (int64_t i = 0; i < part.width; ++i)
                                   row[i] = mask[i] == 0 ? kHole<Raw> : row[i];
                           }
                           return {};
                       });
}

/// Mapbox terrain-RGB: -10000 + 0.1 (65536 R + 256 G + B); Terrarium: 256 R + G + B / 256 - 32768.
Result<void> SampleReader::readEncoded(const SampleWindow& window, std::span<float> raw) {
    const bool isTerrarium = header_.rules.encoding == HeightEncoding::Terrarium;
    return forEachPart(
        window, header_, kPartSamples, [&](const SampleWindow& part) -> Result<void> {
            bytes_.resize(part.size() * 3);
            int bands[3] = {1, 2, 3};
            const auto width = static_cast<int>(part.width), height = static_cast<int>(part.height);
            clearGdalMessage();
            if (dataset_->RasterIO(GF_Read, static_cast<int>(part.column),
                                   static_cast<int>(part.row), width, height, bytes_.data(), width,
                                   height, GDT_Byte, 3, bands, 3, 3 * static_cast<GSpacing>(width),
                                   1, nullptr) != CE_None) {
                return readError(part);
            }
            struct Rgb {
                uint8_t r, g, b;
            };
            spread(reinterpret_cast<const Rgb*>(bytes_.data()), part, window, raw.data(),
                   [isTerrarium](Rgb c) {
                       const int code = c.r << 16 | c.g << 8 | c.b;
                       return static_cast<float>(isTerrarium ? code / 256.0 - 32768
                                                             : -10000 + 0.1 * code);
                   });
            return {};
        });
}

Result<void> SampleReader::readRaw(const SampleWindow& window, std::span<float> raw) {
    const SampleRules& rules = header_.rules;
    if (rules.encoding != HeightEncoding::None) {
        TERRAY_TRY(readEncoded(window, raw));
    } else {
        TERRAY_TRY(fetch(*band_, window, GDT_Float32, raw.data()));
        if (rules.signedByte) signBytes(raw);
    }
    markHoles(raw, rules);
    return applyMask(window, raw);
}

Result<void> SampleReader::readRaw(const SampleWindow& window, std::span<double> raw) {
    const SampleRules& rules = header_.rules;
    TERRAY_TRY(fetch(*band_, window, GDT_Float64, raw.data()));
    if (rules.signedByte) signBytes(raw);
    markHoles(raw, rules);
    return applyMask(window, raw);
}

Result<void> SampleReader::readHeights(const SampleWindow& window, std::span<float> heights) {
    const SampleRules& rules = header_.rules;
    if (!rules.wide) {
        TERRAY_TRY(readRaw(window, heights));
        if (rules.isIdentity()) return {};
        for (float& value : heights) {
            value = static_cast<float>(rules.metres(static_cast<double>(value)));
        }
        return {};
    }
    return forEachPart(
        window, header_, kPartSamples, [&](const SampleWindow& part) -> Result<void> {
            numbers_.resize(part.size());
            TERRAY_TRY(readRaw(part, std::span<double>(numbers_)));
            spread(numbers_.data(), part, window, heights.data(),
                   [&](double value) { return static_cast<float>(rules.metres(value)); });
            return {};
        });
}

template <class Integer>
Result<void> SampleReader::readNarrowCodes(const SampleWindow& window, const PostCodes& codes,
                                           std::span<uint16_t> out) {
    constexpr GDALDataType kType = std::is_signed_v<Integer> ? GDT_Int16 : GDT_UInt16;
    TERRAY_TRY(fetch(*band_, window, kType, out.data()));
    const int nodata = integerNodata(header_.rules), base = static_cast<int>(codes.base);
    const int shift = codes.shift;
    const bool signedByte = header_.rules.signedByte;
    bool outside = false;
    for (uint16_t& word : out) {
        int value = static_cast<Integer>(word);
        if (signedByte) value = static_cast<int8_t>(value);
        const bool isHole = value == nodata;
        const int code = isHole ? kHolePost : (value - base) << shift;
        outside |= !isHole && static_cast<unsigned>(code) > PostCodes::kMaxCode;
        word = static_cast<uint16_t>(code);
    }
    if (outside) return changedError();
    return {};
}

Result<void> SampleReader::readWideCodes(const SampleWindow& window, const PostCodes& codes,
                                         std::span<uint16_t> out) {
    return forEachPart(
        window, header_, kPartSamples, [&](const SampleWindow& part) -> Result<void> {
            numbers_.resize(part.size());
            TERRAY_TRY(readRaw(part, std::span<double>(numbers_)));
            const auto base = static_cast<double>(codes.base);
            const auto most = static_cast<double>(PostCodes::kMaxCode >> codes.shift);
            bool outside = false;
            spread(numbers_.data(), part, window, out.data(), [&](double value) {
                if (std::isnan(value)) return kHolePost;
                outside |= value < base || value - base > most;
                return static_cast<uint16_t>(static_cast<int64_t>(value - base) << codes.shift);
            });
            if (outside) return changedError();
            return {};
        });
}

Result<void> SampleReader::readCodes(const SampleWindow& window, const PostCodes& codes,
                                     std::span<uint16_t> out) {
    const SampleRules& rules = header_.rules;
    if (rules.wide || rules.useMask) return readWideCodes(window, codes, out);
    const bool isSigned = header_.typeMin < 0 && !rules.signedByte;
    return isSigned ? readNarrowCodes<int16_t>(window, codes, out)
                    : readNarrowCodes<uint16_t>(window, codes, out);
}

}  // namespace terray
