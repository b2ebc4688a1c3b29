// SPDX-License-Identifier: Apache-2.0
// The lattice of a warped raster, and the reader that interpolates its posts.
#include "raster/warp.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "raster/interpolate.h"
#include "raster/sample_reader.h"
#include "raster/source_map.h"

namespace terray {
namespace {

constexpr int64_t kMaxSourceSamples = int64_t{1} << 23;  // 32 MiB of floats held by a reader
constexpr int kProbes = 65;                              // places a side that find the extent

struct Rectangle {
    int64_t firstColumn = 0, firstRow = 0, endColumn = 0, endRow = 0;
    bool isEmpty() const { return firstColumn >= endColumn || firstRow >= endRow; }
};

/// The part of a patch inside a window of posts; never empty for patches made for the window.
Rectangle postsInside(const MapPatch& patch, const SampleWindow& window) {
    return {std::max(patch.column, window.column), std::max(patch.row, window.row),
            std::min(patch.column + patch.span, window.column + window.width),
            std::min(patch.row + patch.span, window.row + window.height)};
}

/// Samples that the posts of a window need, with the margin of the cubic.
Rectangle samplesOf(const std::vector<MapPatch>& patches, const SampleWindow& window,
                    const RasterHeader& header) {
    Vec2 lowest{HUGE_VAL, HUGE_VAL}, highest{-HUGE_VAL, -HUGE_VAL};
    for (const MapPatch& patch : patches) {
        const Rectangle inside = postsInside(patch, window);
        if (inside.isEmpty()) continue;
        for (const int64_t j : {inside.firstRow, inside.endRow - 1}) {
            for (const int64_t i : {inside.firstColumn, inside.endColumn - 1}) {
                const Vec2 place = patch.place(i, j);
                if (!std::isfinite(place.x) || !std::isfinite(place.y)) continue;
                lowest = glm::min(lowest, place);
                highest = glm::max(highest, place);
            }
        }
    }
    if (lowest.x > highest.x) return {};
    const auto cut = [](double value, int64_t last) {
        return static_cast<int64_t>(std::clamp(value, 0.0, static_cast<double>(last)));
    };
    return {cut(lowest.x - 2, header.columns), cut(lowest.y - 2, header.rows),
            cut(highest.x + 4, header.columns), cut(highest.y + 4, header.rows)};
}

class WarpReader : public HeightReader {
public:
    WarpReader(const WarpPlan& plan, SourceMap map, std::unique_ptr<SampleReader> reader)
        : header_(plan.header), map_(std::move(map)), reader_(std::move(reader)) {}

    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                      std::span<float> posts) override {
        whole_ = {column, row, width, height};
        return readPart(whole_, posts);
    }

    Result<void> readCodes(int64_t, int64_t, int64_t, int64_t, std::span<uint16_t>) override {
        return makeError(ErrorCode::Failed, "'{}' is warped: its posts are floats, not codes",
                         header_.name);
    }

private:
    /// A part of the window whose samples fit into memory; larger ones are halved.
    Result<void> readPart(const SampleWindow& part, std::span<float> posts) {
        map_.patches(part.column, part.row, part.width, part.height, patches_);
        const Rectangle need = samplesOf(patches_, part, header_);
        if (need.isEmpty()) {
            samples_.clear();
        } else {
            const SampleWindow source{need.firstColumn, need.firstRow,
                                      need.endColumn - need.firstColumn,
                                      need.endRow - need.firstRow};
            if (source.samples() > kMaxSourceSamples && part.samples() > 1) {
                return readHalves(part, posts);
            }
            samples_.resize(source.size());
            TERRAY_TRY(reader_->readHeights(source, samples_));
        }
        field_ = {samples_.data(), need.firstColumn,
                  need.firstRow,   need.endColumn - need.firstColumn,
                  header_.columns, header_.rows};
        // isolated: a waiting thread must not start other work that may use this very reader
        oneapi::tbb::this_task_arena::isolate([&] {
            oneapi::tbb::parallel_for(size_t{0}, patches_.size(), [&](size_t k) {
                fill(patches_[k], part, need.isEmpty(), posts);
            });
        });
        return {};
    }

    Result<void> readHalves(const SampleWindow& part, std::span<float> posts) {
        SampleWindow first = part, second = part;
        if (part.width >= part.height) {
            first.width = part.width / 2;
            second.column += first.width;
            second.width -= first.width;
        } else {
            first.height = part.height / 2;
            second.row += first.height;
            second.height -= first.height;
        }
        TERRAY_TRY(readPart(first, posts));
        return readPart(second, posts);
    }

    void fill(const MapPatch& patch, const SampleWindow& part, bool isEmpty,
              std::span<float> posts) const {
        const Rectangle inside = postsInside(patch, part);
        for (int64_t j = inside.firstRow; j < inside.endRow; ++j) {
            float* out = posts.data() + (j - whole_.row) * whole_.width;
            const MapPatch::Row places = patch.rowPlaces(j);
            for (int64_t i = inside.firstColumn; i < inside.endColumn; ++i) {
                const Vec2 place =
                    places.start + static_cast<double>(i - patch.column) * places.step;
                out[i - whole_.column] = isEmpty ? std::numeric_limits<float>::quiet_NaN()
                                                 : interpolateSample(field_, place.x, place.y);
            }
        }
    }

    RasterHeader header_;
    SourceMap map_;
    std::unique_ptr<SampleReader> reader_;
    SampleWindow whole_;
    std::vector<MapPatch> patches_;
    std::vector<float> samples_;
    SampleField field_;
};

/// World bounds of the raster's pixels, looked at along their rim and inside (poles).
struct Bounds {
    Vec2 min{HUGE_VAL, HUGE_VAL}, max{-HUGE_VAL, -HUGE_VAL};
};

Result<Vec2> worldOfSample(const WarpPlan& plan, const GeoFrame& frame, double i, double j) {
    return frame.worldFromData(plan.dataFromSample.worldFromLattice({i, j}));
}

Bounds worldBounds(const WarpPlan& plan, const GeoFrame& frame) {
    Bounds bounds;
    for (int y = 0; y < kProbes; ++y) {
        for (int x = 0; x < kProbes; ++x) {
            const double i = -0.5 + static_cast<double>(plan.header.columns) * x / (kProbes - 1);
            const double j = -0.5 + static_cast<double>(plan.header.rows) * y / (kProbes - 1);
            const Result<Vec2> world = worldOfSample(plan, frame, i, j);
            if (!world) continue;  // beyond a pole, or outside the projection
            bounds.min = glm::min(bounds.min, *world);
            bounds.max = glm::max(bounds.max, *world);
        }
    }
    return bounds;
}

/// The finer ground size of a pixel at the raster's centre, metres.
Result<double> finerGroundSize(const WarpPlan& plan, const GeoFrame& frame) {
    const double i = 0.5 * static_cast<double>(plan.header.columns - 1);
    const double j = 0.5 * static_cast<double>(plan.header.rows - 1);
    const Result<Vec2> left = worldOfSample(plan, frame, i - 0.5, j);
    const Result<Vec2> right = worldOfSample(plan, frame, i + 0.5, j);
    const Result<Vec2> above = worldOfSample(plan, frame, i, j - 0.5);
    const Result<Vec2> below = worldOfSample(plan, frame, i, j + 0.5);
    for (const Result<Vec2>* place : {&left, &right, &above, &below}) {
        if (!place->ok()) return place->error();
    }
    return std::min(glm::length(*right - *left), glm::length(*below - *above));
}

}  // namespace

Result<GeoFrame> WarpPlan::makeFrame() const {
    Result<GeoFrame> frame = GeoFrame::make(dataCrs, workingCrs);
    if (frame) frame->wrapDataLongitudes(dataCentre.x);
    return frame;
}

Result<void> planLattice(WarpPlan& plan) {
    const Result<GeoFrame> frame = plan.makeFrame();
    if (!frame) return frame.error();
    const Result<double> cell = finerGroundSize(plan, *frame);
    if (!cell) return cell.error();
    const Bounds bounds = worldBounds(plan, *frame);
    const Vec2 size = (bounds.max - bounds.min) / *cell;
    const double samples =
        static_cast<double>(plan.header.columns) * static_cast<double>(plan.header.rows);
    if (!(*cell > 0) || !(size.x > 0) || !(size.y > 0) || size.x * size.y > 64 * samples + 4096) {
        return makeError(ErrorCode::Input,
                         "'{}' cannot be warped: its extent has no sensible place in the working "
                         "CRS; choose another one with --crs, or cut a window",
                         plan.header.name);
    }
    plan.columns = std::max<int64_t>(std::llround(size.x), 2);
    plan.rows = std::max<int64_t>(std::llround(size.y), 2);
    const Vec2 centre = 0.5 * (bounds.min + bounds.max);
    const Vec2 half =
        0.5 * Vec2(static_cast<double>(plan.columns - 1), static_cast<double>(plan.rows - 1)) *
        *cell;
    plan.worldFromLattice = {{centre.x - half.x, centre.y + half.y}, {*cell, 0}, {0, -*cell}};
    return {};
}

Result<std::unique_ptr<HeightReader>> makeWarpReader(const WarpPlan& plan) {
    Result<SourceMap> map = SourceMap::make(plan);
    if (!map) return map.error();
    Result<std::unique_ptr<SampleReader>> reader = SampleReader::open(plan.header);
    if (!reader) return reader.error();
    return std::unique_ptr<HeightReader>(
        std::make_unique<WarpReader>(plan, std::move(*map), std::move(*reader)));
}

}  // namespace terray
