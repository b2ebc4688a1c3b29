// SPDX-License-Identifier: Apache-2.0
// The filters of resamplePhoto.
#include "raster/photo_resample.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "raster/interpolate.h"

namespace terray {
namespace {

using Colour = std::array<float, 4>;

constexpr int kBandRows = 512;  // rows whose map is held at a time

const uint8_t* pixelAt(const RgbaView& source, int64_t i, int64_t j) {
    return source.rgba + ((j - source.y) * source.heldWidth + (i - source.x)) * 4;
}

uint8_t rounded(float value) {
    return static_cast<uint8_t>(std::clamp(value, 0.0f, 255.0f) + 0.5f);
}

/// Bilinear with colours weighted by alpha.
void sampleBilinear(const RgbaView& source, int64_t i, int64_t j, float u, float v, uint8_t* out) {
    const int64_t i1 = std::min<int64_t>(i + 1, source.width - 1);
    const int64_t j1 = std::min<int64_t>(j + 1, source.height - 1);
    const std::array<const uint8_t*, 4> taps{pixelAt(source, i, j), pixelAt(source, i1, j),
                                             pixelAt(source, i, j1), pixelAt(source, i1, j1)};
    const std::array<float, 4> weights{(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
    Colour sum{};
    for (size_t k = 0; k < 4; ++k) {
        const float opacity = weights[k] * taps[k][3];
        for (size_t c = 0; c < 3; ++c) sum[c] += opacity * taps[k][c];
        sum[3] += opacity;
    }
    if (sum[3] < 0.5f) {
        std::fill_n(out, 4, uint8_t{0});
        return;
    }
    for (size_t c = 0; c < 3; ++c) out[c] = rounded(sum[c] / sum[3]);
    out[3] = rounded(sum[3]);
}

/// Bicubic over 4 x 4 opaque pixels from (i - 1, j - 1); false if one is not opaque.
bool sampleBicubic(const RgbaView& source, int64_t i, int64_t j, float u, float v, uint8_t* out) {
    const std::array<float, 4> across = cubicWeights(u), down = cubicWeights(v);
    Colour sum{};
    unsigned opaque = 255;
    for (size_t y = 0; y < 4; ++y) {
        const uint8_t* tap = pixelAt(source, i - 1, j - 1 + static_cast<int64_t>(y));
        Colour line{};
        for (size_t x = 0; x < 4; ++x, tap += 4) {
            opaque &= tap[3];
            for (size_t c = 0; c < 4; ++c) line[c] += across[x] * static_cast<float>(tap[c]);
        }
        for (size_t c = 0; c < 4; ++c) sum[c] += down[y] * line[c];
    }
    if (opaque != 255) return false;
    for (size_t c = 0; c < 3; ++c) out[c] = rounded(sum[c]);
    out[3] = 255;
    return true;
}

void samplePlace(const RgbaView& source, Vec2 place, uint8_t* out) {
    const double lastX = source.width - 1, lastY = source.height - 1;
    if (!(place.x >= -0.5 && place.x <= lastX + 0.5 && place.y >= -0.5 && place.y <= lastY + 0.5)) {
        std::fill_n(out, 4, uint8_t{0});
        return;
    }
    const double x = std::clamp(place.x, 0.0, lastX), y = std::clamp(place.y, 0.0, lastY);
    const auto i = static_cast<int64_t>(x), j = static_cast<int64_t>(y);
    const auto u = static_cast<float>(x - static_cast<double>(i));
    const auto v = static_cast<float>(y - static_cast<double>(j));
    const bool inside = i >= 1 && j >= 1 && i + 2 < source.width && j + 2 < source.height;
    if (inside && sampleBicubic(source, i, j, u, v, out)) return;
    sampleBilinear(source, i, j, u, v, out);
}

}  // namespace

void resamplePatch(const RgbaView& source, const MapPatch& patch, const RgbaWindow& out) {
    const int64_t left = std::max(patch.column, out.column), top = std::max(patch.row, out.row);
    const int64_t right = std::min(patch.column + patch.span, out.column + out.width);
    const int64_t bottom = std::min(patch.row + patch.span, out.row + out.height);
    for (int64_t j = top; j < bottom; ++j) {
        uint8_t* to = out.rgba + (j - out.row) * out.stride + (left - out.column) * 4;
        for (int64_t i = left; i < right; ++i, to += 4) {
            samplePlace(source, patch.place(i, j), to);
        }
    }
}

void resamplePhoto(const RgbaView& source, const SourceMap& map, Photo& photo) {
    std::vector<MapPatch> patches;
    const ptrdiff_t stride = ptrdiff_t{photo.width} * 4;
    for (int top = 0; top < photo.height; top += kBandRows) {
        const int rows = std::min(kBandRows, photo.height - top);
        const RgbaWindow band{photo.rgba.data() + top * stride, stride, 0, top, photo.width, rows};
        map.patches(0, top, photo.width, rows, patches);
        oneapi::tbb::parallel_for(size_t{0}, patches.size(),
                                  [&](size_t k) { resamplePatch(source, patches[k], band); });
    }
}

}  // namespace terray
