// SPDX-License-Identifier: Apache-2.0
// Reading a photo's bands strip by strip into RGBA.
#include "raster/photo_pixels.h"

#include <algorithm>
#include <cmath>

namespace terray {
namespace {

constexpr std::array<double, 2> kWideStretch{2, 98};  ///< percentiles for data that are not 8-bit
constexpr int kSampleSide = 1024;  ///< percentiles come from at most this many pixels a side
constexpr size_t kStripBytes = 16u << 20;

Result<void> checkOptions(GDALDataset& dataset, const std::string& name,
                          const OpenOptions& options) {
    const int count = dataset.GetRasterCount();
    if (count == 0) {
        return makeError(ErrorCode::Input, "'{}' has no bands; give a raster image as --photo",
                         name);
    }
    const std::vector<int>& bands = options.photoBands;
    if (!bands.empty() && bands.size() != 1 && bands.size() != 3) {
        return makeError(
            ErrorCode::Usage,
            "--photo-bands names {} bands; give one (grey) or three (red, green, blue)",
            bands.size());
    }
    for (const int band : bands) {
        if (band >= 1 && band <= count) continue;
        return makeError(ErrorCode::Usage, "--photo-bands: '{}' has no band {}; it has 1 to {}",
                         name, band, count);
    }
    if (options.photoStretch) {
        const auto [low, high] = *options.photoStretch;
        if (!(low >= 0 && low < high && high <= 100)) {
            return makeError(ErrorCode::Usage,
                             "--photo-stretch {},{} is not a pair of percentiles; give for example "
                             "2,98",
                             low, high);
        }
    }
    return {};
}

/// The band with a colour interpretation, or 0.
int bandOf(GDALDataset& dataset, GDALColorInterp colour) {
    for (int band = 1; band <= dataset.GetRasterCount(); ++band) {
        if (dataset.GetRasterBand(band)->GetColorInterpretation() == colour) return band;
    }
    return 0;
}

/// Alpha of any type as 8 bits: 255 (8-bit and float), 65535 and so on are opaque.
double alphaScale(GDALDataType type) {
    switch (type) {
        case GDT_UInt16: return 255.0 / 65535;
        case GDT_Int16: return 255.0 / 32767;
        default: return 1;
    }
}

float percentile(std::vector<float>& values, double percent) {
    const double place = percent / 100 * static_cast<double>(values.size() - 1);
    const auto nth = values.begin() + std::lround(place);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

uint8_t toByte(float value) { return static_cast<uint8_t>(std::clamp(value, 0.0f, 255.0f) + 0.5f); }

/// A few rows of the result at a time, for reads with little memory on the side.
template <class Read>
Result<void> forEachStrip(const PhotoWindow& window, size_t bytesPerPixel, const Read& read) {
    const size_t rowBytes = static_cast<size_t>(window.outWidth) * bytesPerPixel;
    const int rows = static_cast<int>(std::clamp<size_t>(kStripBytes / rowBytes, 1, 1u << 20));
    const double step = static_cast<double>(window.height) / window.outHeight;
    for (int top = 0; top < window.outHeight; top += rows) {
        PhotoStrip strip{window};
        strip.outHeight = std::min(rows, window.outHeight - top);
        strip.exactY = window.y + step * top;
        strip.exactHeight = step * strip.outHeight;
        const int bottom = static_cast<int>(std::ceil(strip.exactY + strip.exactHeight - 1e-6));
        strip.y = static_cast<int>(std::floor(strip.exactY + 1e-6));
        strip.height = std::min(bottom, window.y + window.height) - strip.y;
        TERRAY_TRY(read(strip, top));
    }
    return {};
}

/// Averages a reduced strip over exactly its part of the raster; palettes take the nearest entry.
GDALRasterIOExtraArg extraFor(const PhotoStrip& strip, bool isPalette) {
    GDALRasterIOExtraArg extra;
    INIT_RASTERIO_EXTRA_ARG(extra);
    if (!strip.isReduced()) return extra;
    extra.eResampleAlg = isPalette ? GRIORA_NearestNeighbour : GRIORA_Average;
    extra.bFloatingPointWindowValidity = TRUE;
    extra.dfXOff = strip.x;
    extra.dfXSize = strip.width;
    extra.dfYOff = strip.exactY;
    extra.dfYSize = strip.exactHeight;
    return extra;
}

}  // namespace

Result<PhotoPixels> PhotoPixels::make(GDALDataset& dataset, const std::string& name,
                                      const OpenOptions& options) {
    TERRAY_TRY(checkOptions(dataset, name, options));
    PhotoPixels pixels(dataset, name);
    pixels.chooseBands(options);
    for (const int band : pixels.bands_) {
        const GDALDataType type = dataset.GetRasterBand(band)->GetRasterDataType();
        if (GDALDataTypeIsComplex(type)) {
            return makeError(ErrorCode::Input,
                             "'{}': band {} has complex numbers; choose other bands with "
                             "--photo-bands",
                             name, band);
        }
        if (type != GDT_Byte) pixels.isByte_ = false;
    }
    if (!pixels.isPalette_) {
        pixels.stretch_ = options.photoStretch;
        if (!pixels.isByte_ && !pixels.stretch_) pixels.stretch_ = kWideStretch;
    }
    pixels.chooseAlpha();
    return pixels;
}

void PhotoPixels::chooseBands(const OpenOptions& options) {
    const int count = dataset_->GetRasterCount();
    bands_ = options.photoBands;
    if (bands_.empty()) {
        bands_ = {bandOf(*dataset_, GCI_RedBand), bandOf(*dataset_, GCI_GreenBand),
                  bandOf(*dataset_, GCI_BlueBand)};
        if (std::find(bands_.begin(), bands_.end(), 0) != bands_.end()) {
            const bool hasThree = count >= 3 && bandOf(*dataset_, GCI_AlphaBand) != 3;
            bands_ = hasThree ? std::vector<int>{1, 2, 3} : std::vector<int>{1};
            guessed_ = hasThree;
        }
    }
    isPalette_ =
        bands_.size() == 1 && dataset_->GetRasterBand(bands_[0])->GetColorTable() != nullptr;
}

void PhotoPixels::chooseAlpha() {
    alphaBand_ = bandOf(*dataset_, GCI_AlphaBand);
    if (alphaBand_ != 0) {
        alpha_ = Alpha::Band;
        return;
    }
    GDALRasterBand* const first = dataset_->GetRasterBand(bands_[0]);
    const int flags = first->GetMaskFlags();
    if ((flags & GMF_PER_DATASET) != 0 && (flags & GMF_ALL_VALID) == 0) {
        alpha_ = Alpha::Mask;
        return;
    }
    for (size_t c = 0; c < bands_.size(); ++c) {
        int has = 0;
        const double value = dataset_->GetRasterBand(bands_[c])->GetNoDataValue(&has);
        if (!has) continue;
        nodata_[c] = value;
        alpha_ = Alpha::Nodata;
    }
}

bool PhotoPixels::isNodata(size_t colour, float value) const {
    if (std::isnan(value)) return true;
    return nodata_[colour] && value == static_cast<float>(*nodata_[colour]);
}

Error PhotoPixels::unreadable() const {
    return makeError(ErrorCode::Input, "the photo '{}' cannot be read: {}", name_, gdalMessage());
}

Result<void> PhotoPixels::readBand(GDALRasterBand& band, const PhotoStrip& strip, GDALDataType type,
                                   void* buffer) {
    GDALRasterIOExtraArg extra = extraFor(strip, isPalette_);
    clearGdalMessage();
    if (band.RasterIO(GF_Read, strip.x, strip.y, strip.width, strip.height, buffer, strip.outWidth,
                      strip.outHeight, type, 0, 0, &extra) != CE_None) {
        return unreadable();
    }
    return {};
}

PhotoPixels PhotoPixels::onto(GDALDataset& dataset) const {
    PhotoPixels other = *this;
    other.dataset_ = &dataset;
    return other;
}

Result<void> PhotoPixels::settle(const PhotoWindow& window) {
    TERRAY_TRY(settleStretch(window));
    settled_ = true;
    return {};
}

Result<void> PhotoPixels::read(const PhotoWindow& window, uint8_t* rgba) {
    if (!settled_) TERRAY_TRY(settle(window));
    if (isPalette_) return readPalette(window, rgba);
    return isByte_ && !stretch_ ? readBytes(window, rgba) : readWide(window, rgba);
}

Result<void> PhotoPixels::settleStretch(const PhotoWindow& window) {
    if (!stretch_) return {};
    PhotoWindow sample = window;
    sample.outWidth = std::min(window.width, kSampleSide);
    sample.outHeight = std::min(window.height, kSampleSide);
    std::vector<float> values(static_cast<size_t>(sample.outWidth) *
                              static_cast<size_t>(sample.outHeight));
    for (size_t c = 0; c < bands_.size(); ++c) {
        values.resize(values.capacity());
        GDALRasterBand* const band = dataset_->GetRasterBand(bands_[c]);
        clearGdalMessage();
        if (band->RasterIO(GF_Read, sample.x, sample.y, sample.width, sample.height, values.data(),
                           sample.outWidth, sample.outHeight, GDT_Float32, 0, 0,
                           nullptr) != CE_None) {
            return unreadable();
        }
        std::erase_if(values, [&](float v) { return isNodata(c, v) || !std::isfinite(v); });
        if (values.empty()) continue;
        const float low = percentile(values, (*stretch_)[0]);
        const float high = percentile(values, (*stretch_)[1]);
        ranges_[c] = {low, high > low ? 255 / (high - low) : 1};
    }
    return {};
}

Result<void> PhotoPixels::readBytes(const PhotoWindow& window, uint8_t* rgba) {
    const GSpacing lineStep = static_cast<GSpacing>(window.outWidth) * 4;
    std::array<int, 3> map{bands_.front(), bands_[bands_.size() / 2], bands_.back()};
    const Result<void> colours =
        forEachStrip(window, 4, [&](const PhotoStrip& strip, int top) -> Result<void> {
            uint8_t* const out = rgba + top * lineStep;
            GDALRasterIOExtraArg extra = extraFor(strip, false);
            clearGdalMessage();
            if (dataset_->RasterIO(GF_Read, strip.x, strip.y, strip.width, strip.height, out,
                                   strip.outWidth, strip.outHeight, GDT_Byte, 3, map.data(), 4,
                                   lineStep, 1, &extra) != CE_None) {
                return unreadable();
            }
            const size_t count =
                static_cast<size_t>(strip.outWidth) * static_cast<size_t>(strip.outHeight);
            for (size_t k = 0; k < count; ++k) out[4 * k + 3] = 255;
            if (alpha_ != Alpha::Nodata) return {};
            for (size_t k = 0; k < count; ++k) {
                bool hole = true;
                for (size_t c = 0; c < bands_.size(); ++c) {
                    hole = hole && isNodata(c, out[4 * k + c]);
                }
                if (hole) std::fill_n(out + 4 * k, 4, uint8_t{0});
            }
            return {};
        });
    if (!colours) return colours;
    return applyAlpha(window, rgba);
}

Result<void> PhotoPixels::readWide(const PhotoWindow& window, uint8_t* rgba) {
    const size_t bandCount = bands_.size();
    std::vector<float> values;
    const Result<void> colours = forEachStrip(
        window, bandCount * sizeof(float), [&](const PhotoStrip& strip, int top) -> Result<void> {
            const size_t count =
                static_cast<size_t>(strip.outWidth) * static_cast<size_t>(strip.outHeight);
            values.resize(count * bandCount);
            for (size_t c = 0; c < bandCount; ++c) {
                TERRAY_TRY(readBand(*dataset_->GetRasterBand(bands_[c]), strip, GDT_Float32,
                                    values.data() + c * count));
            }
            uint8_t* out =
                rgba + static_cast<size_t>(top) * static_cast<size_t>(strip.outWidth) * 4;
            for (size_t k = 0; k < count; ++k, out += 4) {
                size_t missing = 0;
                for (size_t c = 0; c < 3; ++c) {
                    const size_t from = std::min(c, bandCount - 1);
                    const float v = values[from * count + k];
                    if (isNodata(from, v)) ++missing;
                    out[c] = std::isnan(v) ? uint8_t{0}
                                           : toByte((v - ranges_[from].low) * ranges_[from].scale);
                }
                out[3] = 255;
                if (missing == 3) std::fill_n(out, 4, uint8_t{0});
            }
            return {};
        });
    if (!colours) return colours;
    return applyAlpha(window, rgba);
}

Result<void> PhotoPixels::readPalette(const PhotoWindow& window, uint8_t* rgba) {
    GDALRasterBand* const band = dataset_->GetRasterBand(bands_[0]);
    const GDALColorTable& table = *band->GetColorTable();
    std::vector<uint16_t> indices;
    const Result<void> colours = forEachStrip(
        window, sizeof(uint16_t), [&](const PhotoStrip& strip, int top) -> Result<void> {
            const size_t count =
                static_cast<size_t>(strip.outWidth) * static_cast<size_t>(strip.outHeight);
            indices.resize(count);
            TERRAY_TRY(readBand(*band, strip, GDT_UInt16, indices.data()));
            uint8_t* out =
                rgba + static_cast<size_t>(top) * static_cast<size_t>(strip.outWidth) * 4;
            for (size_t k = 0; k < count; ++k, out += 4) {
                const GDALColorEntry* entry = table.GetColorEntry(indices[k]);
                if (entry == nullptr || isNodata(0, indices[k])) {
                    std::fill_n(out, 4, uint8_t{0});
                    continue;
                }
                out[0] = static_cast<uint8_t>(entry->c1);
                out[1] = static_cast<uint8_t>(entry->c2);
                out[2] = static_cast<uint8_t>(entry->c3);
                out[3] = static_cast<uint8_t>(entry->c4);
            }
            return {};
        });
    if (!colours) return colours;
    return applyAlpha(window, rgba);
}

Result<void> PhotoPixels::applyAlpha(const PhotoWindow& window, uint8_t* rgba) {
    if (alpha_ != Alpha::Band && alpha_ != Alpha::Mask) return {};
    GDALRasterBand* const band = alpha_ == Alpha::Band
                                     ? dataset_->GetRasterBand(alphaBand_)
                                     : dataset_->GetRasterBand(bands_[0])->GetMaskBand();
    const double scale = alphaScale(band->GetRasterDataType());
    std::vector<float> values;
    return forEachStrip(
        window, sizeof(float), [&](const PhotoStrip& strip, int top) -> Result<void> {
            const size_t count =
                static_cast<size_t>(strip.outWidth) * static_cast<size_t>(strip.outHeight);
            values.resize(count);
            TERRAY_TRY(readBand(*band, strip, GDT_Float32, values.data()));
            uint8_t* out =
                rgba + static_cast<size_t>(top) * static_cast<size_t>(strip.outWidth) * 4;
            for (size_t k = 0; k < count; ++k, out += 4) {
                const uint8_t alpha = toByte(values[k] * static_cast<float>(scale));
                out[3] = std::min(out[3], alpha);
                if (alpha == 0) std::fill_n(out, 4, uint8_t{0});
            }
            return {};
        });
}

std::string PhotoPixels::description() const {
    std::string text = bands_.size() == 1 ? "band " : "bands ";
    for (size_t c = 0; c < bands_.size(); ++c) {
        text += fmt::format("{}{}", c == 0 ? "" : ", ", bands_[c]);
    }
    if (guessed_) text += " (taken as red, green, blue: the file does not say)";
    if (isPalette_) text += " with its palette";
    if (stretch_) {
        text += fmt::format(", stretched from {:g} to {:g} %", (*stretch_)[0], (*stretch_)[1]);
    }
    return text;
}

}  // namespace terray
