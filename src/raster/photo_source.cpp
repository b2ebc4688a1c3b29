// SPDX-License-Identifier: Apache-2.0
// Windows of a photo: read as they lie, or resampled from the part of the file that they need.
#include "raster/photo_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/assert.h"
#include "raster/photo_resample.h"
#include "raster/source_map.h"

namespace terray {
namespace {

constexpr int64_t kMaxSourcePixels = int64_t{1} << 22;  ///< 16 MiB held by a reader
constexpr int64_t kWarpedRows = 512;
constexpr int64_t kFewestRows = 64;

/// Places that hold windows of the file; each dataset is one thread's.
struct OpenedFile {
    DatasetHandle dataset;
    PhotoPixels pixels;
};

Result<OpenedFile> openAgain(const PhotoPlan& plan, const PhotoPixels& pixels) {
    Result<OpenedRaster> opened = openRaster(plan.path);
    if (!opened) return opened.error();
    GDALDataset& dataset = *opened->dataset;
    if (dataset.GetRasterXSize() != plan.dataset->GetRasterXSize() ||
        dataset.GetRasterYSize() != plan.dataset->GetRasterYSize() ||
        dataset.GetRasterCount() != plan.dataset->GetRasterCount()) {
        return makeError(ErrorCode::Input, "the photo '{}' has changed while it was read",
                         plan.path);
    }
    PhotoPixels same = pixels.onto(dataset);
    return OpenedFile{std::move(opened->dataset), std::move(same)};
}

PhotoWindow wholeWindow(int64_t x, int64_t y, int64_t width, int64_t height) {
    PhotoWindow window;
    window.x = static_cast<int>(x);
    window.y = static_cast<int>(y);
    window.width = window.outWidth = static_cast<int>(width);
    window.height = window.outHeight = static_cast<int>(height);
    return window;
}

void copyRows(const std::vector<uint8_t>& from, int64_t width, int64_t height, uint8_t* to,
              ptrdiff_t stride) {
    for (int64_t row = 0; row < height; ++row) {
        std::copy_n(from.data() + row * width * 4, width * 4, to + row * stride);
    }
}

class DirectReader final : public PhotoReader {
public:
    DirectReader(const PhotoWindow& window, OpenedFile file)
        : window_(window), file_(std::move(file)) {}

    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height, uint8_t* rgba,
                      ptrdiff_t stride) override {
        const PhotoWindow part = wholeWindow(window_.x + column, window_.y + row, width, height);
        if (stride == width * 4) return file_.pixels.read(part, rgba);
        scratch_.resize(static_cast<size_t>(width * height * 4));
        TERRAY_TRY(file_.pixels.read(part, scratch_.data()));
        copyRows(scratch_, width, height, rgba, stride);
        return {};
    }

private:
    PhotoWindow window_;
    OpenedFile file_;
    std::vector<uint8_t> scratch_;
};

class WarpedPhotoReader final : public PhotoReader {
public:
    WarpedPhotoReader(const PhotoWindow& window, SourceMap map, OpenedFile file)
        : window_(window), map_(std::move(map)), file_(std::move(file)) {}

    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height, uint8_t* rgba,
                      ptrdiff_t stride) override {
        return readPart({rgba, stride, column, row, width, height});
    }

private:
    /// A part of the window whose source pixels fit into memory; larger ones are halved.
    Result<void> readPart(const RgbaWindow& part) {
        map_.patches(part.column, part.row, part.width, part.height, patches_);
        const PhotoWindow need = neededBy(part);
        RgbaView view{nullptr, window_.width, window_.height, need.width, need.x, need.y};
        if (need.width > 0) {
            const int64_t pixels = int64_t{need.width} * need.height;
            if (pixels > kMaxSourcePixels && part.width * part.height > 1) return readHalves(part);
            source_.resize(static_cast<size_t>(pixels) * 4);
            TERRAY_TRY(file_.pixels.read(
                wholeWindow(window_.x + need.x, window_.y + need.y, need.width, need.height),
                source_.data()));
            view.rgba = source_.data();
        }
        if (view.rgba == nullptr) {
            for (int64_t row = 0; row < part.height; ++row) {
                std::fill_n(part.rgba + row * part.stride, part.width * 4, uint8_t{0});
            }
            return {};
        }
        for (const MapPatch& patch : patches_) resamplePatch(view, patch, part);
        return {};
    }

    Result<void> readHalves(const RgbaWindow& part) {
        RgbaWindow first = part, second = part;
        if (part.width >= part.height) {
            first.width = part.width / 2;
            second.column += first.width;
            second.width -= first.width;
            second.rgba += first.width * 4;
        } else {
            first.height = part.height / 2;
            second.row += first.height;
            second.height -= first.height;
            second.rgba += first.height * part.stride;
        }
        TERRAY_TRY(readPart(first));
        return readPart(second);
    }

    /// Pixels of the planned window that the part's pixels look at, with the filter's margin;
    /// width 0: none.
    PhotoWindow neededBy(const RgbaWindow& part) const {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        Vec2 lowest{kInfinity}, highest{-kInfinity};
        for (const MapPatch& patch : patches_) {
            const int64_t right = std::min(patch.column + patch.span, part.column + part.width);
            const int64_t bottom = std::min(patch.row + patch.span, part.row + part.height);
            for (const int64_t j : {std::max(patch.row, part.row), bottom - 1}) {
                for (const int64_t i : {std::max(patch.column, part.column), right - 1}) {
                    const Vec2 place = patch.place(i, j);
                    if (!std::isfinite(place.x) || !std::isfinite(place.y)) continue;
                    lowest = glm::min(lowest, place);
                    highest = glm::max(highest, place);
                }
            }
        }
        if (lowest.x > highest.x) return {};
        const auto cut = [](double value, int last) {
            return static_cast<int64_t>(std::clamp(value, 0.0, static_cast<double>(last)));
        };
        const int64_t left = cut(lowest.x - 2, window_.width);
        const int64_t top = cut(lowest.y - 2, window_.height);
        const int64_t right = cut(highest.x + 4, window_.width);
        const int64_t bottom = cut(highest.y + 4, window_.height);
        if (left >= right || top >= bottom) return {};
        return wholeWindow(left, top, right - left, bottom - top);
    }

    PhotoWindow window_;
    SourceMap map_;
    OpenedFile file_;
    std::vector<MapPatch> patches_;
    std::vector<uint8_t> source_;
};

class FilePhotoSource final : public PhotoSource {
public:
    FilePhotoSource(PhotoPlan plan, PhotoPixels pixels)
        : plan_(std::move(plan)),
          pixels_(std::move(pixels)),
          description_(plan_.describe(pixels_)) {}

    int64_t columns() const override { return plan_.columns; }
    int64_t rows() const override { return plan_.rows; }
    const Affine2& worldFromPixel() const override { return plan_.worldFromPixel; }
    const std::string& description() const override { return description_; }

    Result<std::unique_ptr<PhotoReader>> makeReader() const override {
        auto file = openAgain(plan_, pixels_);
        if (!file) return file.error();
        if (!plan_.warp) {
            return std::unique_ptr<PhotoReader>(new DirectReader(plan_.window, std::move(*file)));
        }
        Result<SourceMap> map = SourceMap::make(*plan_.warp);
        if (!map) return map.error();
        return std::unique_ptr<PhotoReader>(
            new WarpedPhotoReader(plan_.window, std::move(*map), std::move(*file)));
    }

    int64_t preferredRows() const override {
        if (plan_.warp) return kWarpedRows;
        int blockX = 0, blockY = 0;
        plan_.dataset->GetRasterBand(1)->GetBlockSize(&blockX, &blockY);
        return std::clamp<int64_t>(blockY, kFewestRows, kWarpedRows);
    }

private:
    PhotoPlan plan_;
    PhotoPixels pixels_;
    std::string description_;
};

}  // namespace

Result<std::unique_ptr<PhotoSource>> openPhotoSource(const std::string& path,
                                                     const OpenOptions& options, PhotoPlace place) {
    ensureGdal();
    Result<PhotoPlan> plan = openPhoto(path);
    if (!plan) return plan.error();
    Result<PhotoPixels> pixels = PhotoPixels::make(*plan->dataset, path, options);
    if (!pixels) return pixels.error();
    place.maxBytes = UINT64_MAX;
    TERRAY_TRY(planPhoto(place, *plan));
    TERRAY_ASSERT(!plan->window.isReduced());
    TERRAY_TRY(pixels->settle(plan->window));
    return std::unique_ptr<PhotoSource>(
        std::make_unique<FilePhotoSource>(std::move(*plan), std::move(*pixels)));
}

}  // namespace terray
