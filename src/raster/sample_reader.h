// SPDX-License-Identifier: Apache-2.0
// Samples of a raster, window by window: raw numbers, heights in metres, or 16-bit codes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "raster/post_codes.h"
#include "raster/raster_header.h"

namespace terray {

struct SampleWindow {
    int64_t column = 0, row = 0, width = 0, height = 0;
    int64_t samples() const { return width * height; }
    size_t size() const { return static_cast<size_t>(width * height); }
};

/// Samples of a part that a reader holds at once: 8 MiB of doubles.
constexpr int64_t kPartSamples = int64_t{1} << 20;

/// Cuts a window into parts of at most about `maxSamples` that follow the file's blocks, so that no
/// block is decoded twice. Stops at the first error.
Result<void> forEachPart(const SampleWindow& window, const RasterHeader& header, int64_t maxSamples,
                         const std::function<Result<void>(const SampleWindow&)>& use);

/// Reads one band (or the three of an encoding). confined: one reader per thread.
class SampleReader {
public:
    /// Opens the raster again. Error Input if it is not what the header said any more.
    static Result<std::unique_ptr<SampleReader>> open(const RasterHeader& header);

    /// Raw values, NaN for holes. The float version is exact unless rules.wide.
    Result<void> readRaw(const SampleWindow& window, std::span<float> raw);
    Result<void> readRaw(const SampleWindow& window, std::span<double> raw);
    /// Heights in metres, rounded once to float; NaN for holes.
    Result<void> readHeights(const SampleWindow& window, std::span<float> heights);
    /// Codes of integer samples; kHolePost for holes. Error Input if one lies outside the codes.
    Result<void> readCodes(const SampleWindow& window, const PostCodes& codes,
                           std::span<uint16_t> out);

private:
    SampleReader(const RasterHeader& header, DatasetHandle dataset);

    Result<void> fetch(GDALRasterBand& band, const SampleWindow& window, GDALDataType type,
                       void* out);
    Result<void> readEncoded(const SampleWindow& window, std::span<float> raw);
    template <class Raw>
    Result<void> applyMask(const SampleWindow& window, std::span<Raw> raw);
    template <class Integer>
    Result<void> readNarrowCodes(const SampleWindow& window, const PostCodes& codes,
                                 std::span<uint16_t> out);
    Result<void> readWideCodes(const SampleWindow& window, const PostCodes& codes,
                               std::span<uint16_t> out);
    Error readError(const SampleWindow& window) const;
    Error changedError() const;

    RasterHeader header_;
    DatasetHandle dataset_;
    GDALRasterBand* band_;
    std::vector<uint8_t> bytes_;   // scratch: masks, colours
    std::vector<double> numbers_;  // scratch: wide raw values
};

}  // namespace terray
