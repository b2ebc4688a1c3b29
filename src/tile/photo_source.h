// SPDX-License-Identifier: Apache-2.0
// PhotoSource: whoever delivers a photo's pixels on one lattice in the working CRS, window by
// window.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "math/affine.h"

namespace terray {

/// One reader per thread (confined).
class PhotoReader {
public:
    virtual ~PhotoReader() = default;
    /// Fills straight-alpha sRGB, 4 bytes a pixel, rows `stride` bytes apart; alpha 0 where the
    /// photo does not cover. The window lies inside the lattice. A pixel is the same from every
    /// window.
    virtual Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                              uint8_t* rgba, ptrdiff_t stride) = 0;
};

/// const-shared: any thread may ask for a reader.
class PhotoSource {
public:
    virtual ~PhotoSource() = default;
    virtual int64_t columns() const = 0;
    virtual int64_t rows() const = 0;
    /// World place of pixel (i, j)'s centre at lattice place (i, j).
    virtual const Affine2& worldFromPixel() const = 0;
    /// One line for the output: size, bands used, stretch, warp.
    virtual const std::string& description() const = 0;
    virtual Result<std::unique_ptr<PhotoReader>> makeReader() const = 0;
    /// Rows that are cheap to read together; >= 1. Above 256: so are windows that are not wide.
    virtual int64_t preferredRows() const { return 64; }
};

}  // namespace terray
