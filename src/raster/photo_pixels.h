// SPDX-License-Identifier: Apache-2.0
// A photo's bands as 8-bit RGBA: which bands are colours, what is alpha, how values are stretched.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "dataset/gdal_handle.h"
#include "terray/options.h"

namespace terray {

/// Pixels [x, x + width) x [y, y + height) of a raster, read as outWidth x outHeight.
struct PhotoWindow {
    int x = 0, y = 0, width = 0, height = 0;
    int outWidth = 0, outHeight = 0;
    bool isReduced() const { return outWidth != width || outHeight != height; }
};

/// Some rows of a window's result: the exact part of the raster that they stand for, in pixels.
struct PhotoStrip : PhotoWindow {
    double exactY = 0, exactHeight = 0;
};

/// Reads windows of a dataset as straight-alpha RGBA. confined, like the dataset.
class PhotoPixels {
public:
    /// Errors: Usage (--photo-bands, --photo-stretch), Input (complex samples).
    static Result<PhotoPixels> make(GDALDataset& dataset, const std::string& name,
                                    const OpenOptions& options);

    /// The same choices, stretch included, for another opened dataset of the same file.
    PhotoPixels onto(GDALDataset& dataset) const;
    /// Settles the stretch from samples of a window.
    Result<void> settle(const PhotoWindow& window);
    /// Fills outWidth * outHeight * 4 bytes. The first call settles the stretch, from its window,
    /// unless that has been done.
    Result<void> read(const PhotoWindow& window, uint8_t* rgba);

    /// "bands 3, 2, 1, stretched from 2 to 98 %".
    std::string description() const;

private:
    enum class Alpha { None, Band, Mask, Nodata };
    struct Range {
        float low = 0, scale = 1;  ///< 8-bit value = (v - low) * scale
    };
    PhotoPixels(GDALDataset& dataset, std::string name)
        : dataset_(&dataset), name_(std::move(name)) {}

    void chooseBands(const OpenOptions& options);
    void chooseAlpha();
    Result<void> settleStretch(const PhotoWindow& window);
    Result<void> readBytes(const PhotoWindow& window, uint8_t* rgba);
    Result<void> readWide(const PhotoWindow& window, uint8_t* rgba);
    Result<void> readPalette(const PhotoWindow& window, uint8_t* rgba);
    Result<void> readBand(GDALRasterBand& band, const PhotoStrip& strip, GDALDataType type,
                          void* buffer);
    Result<void> applyAlpha(const PhotoWindow& window, uint8_t* rgba);
    bool isNodata(size_t colour, float value) const;
    Error unreadable() const;

    GDALDataset* dataset_;
    std::string name_;
    std::vector<int> bands_;  // 1 (grey or palette) or 3
    bool guessed_ = false;    // no colour interpretation said so
    Alpha alpha_ = Alpha::None;
    int alphaBand_ = 0;
    std::array<std::optional<double>, 3> nodata_;
    bool isPalette_ = false, isByte_ = true;
    std::optional<std::array<double, 2>> stretch_;
    std::array<Range, 3> ranges_;
    bool settled_ = false;
};

}  // namespace terray
