// SPDX-License-Identifier: Apache-2.0
// Makes the sky-light field from an overview of the terrain and reads it.
#include "shade/sky.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "kernel/sweep/sky.h"

namespace terray {
namespace {

constexpr int kAzimuths = 16;
constexpr float kCodes = 65535.0f;

/// Holes take the mean of their valid neighbours, so that the ground at a hole's rim is not
/// brightened by it.
void fillRims(const Overview& view, std::vector<float>& open) {
    const int w = view.width, h = view.height;
    oneapi::tbb::parallel_for(0, h, [&](int j) {
        for (int i = 0; i < w; ++i) {
            const size_t at = static_cast<size_t>(j) * static_cast<size_t>(w) + static_cast<size_t>(i);
            if (!std::isnan(view.heights[at])) continue;
            float sum = 0, count = 0;
            for (int y = std::max(0, j - 1); y <= std::min(h - 1, j + 1); ++y) {
                for (int x = std::max(0, i - 1); x <= std::min(w - 1, i + 1); ++x) {
                    const size_t near =
                        static_cast<size_t>(y) * static_cast<size_t>(w) + static_cast<size_t>(x);
                    if (std::isnan(view.heights[near])) continue;
                    sum += open[near];
                    count += 1;
                }
            }
            if (count > 0) open[at] = sum / count;
        }
    });
}

}  // namespace

SkyLight::SkyLight(Overview overview, const Affine2& worldFromLattice, double exaggeration)
    : width_(overview.width), height_(overview.height), scale_(std::ldexp(1.0, -overview.mip)) {
    const auto factor = static_cast<float>(exaggeration);
    for (float& z : overview.heights) z *= factor;
    std::vector<float> open(overview.heights.size());
    computeSkyVisibility({overview.heights.data(), width_, height_,
                          worldFromLattice.columnLength() / scale_,
                          worldFromLattice.rowLength() / scale_},
                         kAzimuths, open);
    fillRims(overview, open);
    open_.resize(open.size());
    for (size_t k = 0; k < open.size(); ++k)
        open_[k] = static_cast<uint16_t>(std::clamp(open[k], 0.0f, 1.0f) * kCodes + 0.5f);
}

float SkyLight::at(double i, double j) const {
    const double x = std::clamp(i * scale_, 0.0, static_cast<double>(width_ - 1));
    const double y = std::clamp(j * scale_, 0.0, static_cast<double>(height_ - 1));
    const int column = std::min(static_cast<int>(x), std::max(width_ - 2, 0));
    const int row = std::min(static_cast<int>(y), std::max(height_ - 2, 0));
    const float u = static_cast<float>(x - column), v = static_cast<float>(y - row);
    const uint16_t* top =
        &open_[static_cast<size_t>(row) * static_cast<size_t>(width_) + static_cast<size_t>(column)];
    const uint16_t* bottom = top + width_;
    const float upper = static_cast<float>(top[0]) * (1 - u) + static_cast<float>(top[1]) * u;
    const float lower = static_cast<float>(bottom[0]) * (1 - u) + static_cast<float>(bottom[1]) * u;
    return (upper * (1 - v) + lower * v) * (1.0f / kCodes);
}

}  // namespace terray
