// SPDX-License-Identifier: Apache-2.0
// Makes the sky-light field from an overview of the terrain and reads it.
#include "shade/sky.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "kernel/sweep/sky.h"
#include "shade/rules/filter.h"

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
            const size_t at =
                static_cast<size_t>(j) * static_cast<size_t>(w) + static_cast<size_t>(i);
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

SkyLight::SkyLight(Overview overview, const Affine2& worldFromLattice, double exaggeration) {
    Mip finest;
    finest.width = overview.width;
    finest.height = overview.height;
    finest.scale = std::ldexp(1.0, -overview.mip);
    const auto factor = static_cast<float>(exaggeration);
    for (float& z : overview.heights) z *= factor;
    std::vector<float> open(overview.heights.size());
    computeSkyVisibility({overview.heights.data(), finest.width, finest.height,
                          worldFromLattice.columnLength() / finest.scale,
                          worldFromLattice.rowLength() / finest.scale},
                         kAzimuths, open);
    fillRims(overview, open);
    finest.open.resize(open.size());
    for (size_t k = 0; k < open.size(); ++k)
        finest.open[k] = static_cast<uint16_t>(std::clamp(open[k], 0.0f, 1.0f) * kCodes + 0.5f);
    mips_.push_back(std::move(finest));
    while (mips_.back().width >= 4 && mips_.back().height >= 4)
        mips_.push_back(halve(mips_.back()));
}

SkyLight::Mip SkyLight::halve(const Mip& fine) {
    Mip coarse;
    coarse.width = fine.width / 2;
    coarse.height = fine.height / 2;
    coarse.scale = fine.scale * 0.5;
    coarse.shift = fine.shift * 0.5 - 0.25;
    coarse.open.resize(static_cast<size_t>(coarse.width) * static_cast<size_t>(coarse.height));
    for (int j = 0; j < coarse.height; ++j) {
        const uint16_t* top =
            &fine.open[static_cast<size_t>(2 * j) * static_cast<size_t>(fine.width)];
        const uint16_t* bottom = top + fine.width;
        uint16_t* out = &coarse.open[static_cast<size_t>(j) * static_cast<size_t>(coarse.width)];
        for (int i = 0; i < coarse.width; ++i)
            out[i] = static_cast<uint16_t>(
                (top[2 * i] + top[2 * i + 1] + bottom[2 * i] + bottom[2 * i + 1] + 2) / 4);
    }
    return coarse;
}

float SkyLight::Mip::at(double i, double j) const {
    const double x = std::clamp(i * scale + shift, 0.0, static_cast<double>(width - 1));
    const double y = std::clamp(j * scale + shift, 0.0, static_cast<double>(height - 1));
    const int column = std::min(static_cast<int>(x), width - 2);
    const int row = std::min(static_cast<int>(y), height - 2);
    const float u = static_cast<float>(x - column), v = static_cast<float>(y - row);
    const uint16_t* top =
        &open[static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(column)];
    const uint16_t* bottom = top + width;
    const float upper = static_cast<float>(top[0]) * (1 - u) + static_cast<float>(top[1]) * u;
    const float lower = static_cast<float>(bottom[0]) * (1 - u) + static_cast<float>(bottom[1]) * u;
    return (upper * (1 - v) + lower * v) * (1.0f / kCodes);
}

float SkyLight::at(double i, double j, float footprint) const {
    const float posts = footprint * static_cast<float>(mips_[0].scale);
    const rules::MipBlend blend = rules::mipBlend(posts, static_cast<int>(mips_.size()) - 1);
    const float fine = mips_[static_cast<size_t>(blend.mip)].at(i, j);
    if (blend.coarser <= 0) return fine;
    return fine + blend.coarser * (mips_[static_cast<size_t>(blend.mip) + 1].at(i, j) - fine);
}

}  // namespace terray
