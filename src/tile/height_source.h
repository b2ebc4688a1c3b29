// SPDX-License-Identifier: Apache-2.0
// HeightSource: whoever delivers the posts of mip 0 (a GDAL raster, a synthetic terrain), row by
// row.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/result.h"
#include "tile/terrain_info.h"

namespace terray {

/// Reads windows of posts of mip 0. One reader per thread (confined).
class HeightReader {
public:
    virtual ~HeightReader() = default;
    /// Fills `posts` row by row with the decoded heights in metres; holes are NaN.
    /// The window lies inside the lattice; posts.size() == width * height.
    virtual Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                              std::span<float> posts) = 0;
    /// The same as codes (info().format == Int16 only); holes are kHolePost.
    virtual Result<void> readCodes(int64_t column, int64_t row, int64_t width, int64_t height,
                                   std::span<uint16_t> codes) = 0;
};

/// const-shared: any thread may ask for a reader.
class HeightSource {
public:
    virtual ~HeightSource() = default;
    virtual const TerrainInfo& info() const = 0;
    virtual Result<std::unique_ptr<HeightReader>> makeReader() const = 0;
    /// Rows that are cheap to read together (block height of the file); >= 1.
    virtual int64_t preferredRows() const { return 64; }
};

}  // namespace terray
