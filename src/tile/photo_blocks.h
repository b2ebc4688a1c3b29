// SPDX-License-Identifier: Apache-2.0
// PhotoBlockSource: whoever delivers finished blocks of all mips of a photo (the store).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "math/affine.h"

namespace terray {

constexpr int kPhotoBlockLog2 = 9;
constexpr int kPhotoBlockSide = 1 << kPhotoBlockLog2;  ///< pixels
constexpr size_t kPhotoBlockBytes = size_t{kPhotoBlockSide} * kPhotoBlockSide * 4;

/// A photo on a lattice of its own: mip 0 as read, each further mip half the pixels of the one
/// before (rounded up), until all of it is one block. Pixels are areas: pixel (i, j) of mip m
/// covers pixels (2 i, 2 j) to (2 i + 1, 2 j + 1) of mip m - 1, as far as they exist.
struct PhotoGrid {
    int64_t columns = 0, rows = 0;
    int64_t columnsAt(int mip) const { return (columns + (int64_t{1} << mip) - 1) >> mip; }
    int64_t rowsAt(int mip) const { return (rows + (int64_t{1} << mip) - 1) >> mip; }
    int blocksX(int mip) const { return blocksOver(columnsAt(mip)); }
    int blocksY(int mip) const { return blocksOver(rowsAt(mip)); }
    int mipCount() const {
        int mips = 1;
        while (blocksX(mips - 1) > 1 || blocksY(mips - 1) > 1) ++mips;
        return mips;
    }

private:
    static int blocksOver(int64_t pixels) {
        return static_cast<int>((pixels + kPhotoBlockSide - 1) / kPhotoBlockSide);
    }
};

/// One reader per thread (confined).
class PhotoBlockReader {
public:
    virtual ~PhotoBlockReader() = default;
    /// Block (x, y) of a mip, kPhotoBlockBytes: 512 x 512 pixels of straight-alpha sRGB, 4 bytes
    /// each; 0 where the photo does not cover and beyond the mip's edge.
    virtual Result<void> read(int mip, int x, int y, uint8_t* rgba) = 0;
    /// Bytes read of files, as they lie there; 0 where there are none.
    virtual uint64_t bytesRead() const { return 0; }
};

/// const-shared: any thread may ask for a reader.
class PhotoBlockSource {
public:
    virtual ~PhotoBlockSource() = default;
    virtual PhotoGrid grid() const = 0;
    /// Centre of pixel (i, j) of mip 0, metres.
    virtual const Affine2& worldFromPixel() const = 0;
    virtual const std::string& description() const = 0;
    virtual Result<std::unique_ptr<PhotoBlockReader>> makeReader() const = 0;
};

}  // namespace terray
