// SPDX-License-Identifier: Apache-2.0
// Makes the sky-light field from an overview of the terrain and reads it.
#include "shade/sky.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/simd_clones.h"
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

/// Four posts around each place: where they begin in their mip, and the place between them.
struct SkyCells {
    Ints first, width;
    Floats u, v;
    Lanes<uint64_t> posts;  ///< all four, from the low end
};

TERRAY_SIMD_CLONES
void chooseSkyMips(const Floats& footprint, float perCell, int last, Ints& mip, Floats& coarser) {
    for (int k = 0; k < kBatch; ++k) {
        const rules::MipBlend blend = rules::mipBlend(footprint[k] * perCell, last);
        mip[k] = blend.mip;
        coarser[k] = blend.coarser;
    }
}

/// As Mip::at() places them; sizes and shift of a mip follow from those of the finest, which is
/// made of mip `finest` of the terrain.
TERRAY_SIMD_CLONES
void locateSky(const Ints& mip, int width, int height, int finest, const Places& places,
               SkyCells& c) {
    for (int k = 0; k < kBatch; ++k) {
        const int32_t m = mip[k] + finest, within = (1 << m) - 1;
        const float perCell = std::bit_cast<float>((127 - m) << 23);
        const float shift = 0.5f * std::bit_cast<float>((127 - mip[k]) << 23) - 0.5f;
        const int32_t x = places.x[k], y = places.y[k];
        const float inX = (static_cast<float>(x & within) + places.dx[k]) * perCell + shift;
        const float inY = (static_cast<float>(y & within) + places.dy[k]) * perCell + shift;
        // Rounded down: the shift is above -1.
        const int32_t aheadX = static_cast<int32_t>(inX + 1.0f) - 1;
        const int32_t aheadY = static_cast<int32_t>(inY + 1.0f) - 1;
        const int32_t w = width >> mip[k], h = height >> mip[k];
        const int32_t column = (x >> m) + aheadX, row = (y >> m) + aheadY;
        float u = inX - static_cast<float>(aheadX), v = inY - static_cast<float>(aheadY);
        u = column < 0 ? 0.0f : u;
        v = row < 0 ? 0.0f : v;
        c.u[k] = column > w - 2 ? 1.0f : u;
        c.v[k] = row > h - 2 ? 1.0f : v;
        const int32_t left = column < 0 ? 0 : column, top = row < 0 ? 0 : row;
        c.first[k] = (top < h - 2 ? top : h - 2) * w + (left < w - 2 ? left : w - 2);
        c.width[k] = w;
    }
}

/// Goes on to the coarser mips of a blend; true if any is needed.
TERRAY_SIMD_CLONES
bool nextMips(const Floats& coarser, int last, Ints& mip) {
    int32_t any = 0;
    for (int k = 0; k < kBatch; ++k) {
        any |= coarser[k] > 0.0f ? 1 : 0;
        mip[k] = mip[k] < last ? mip[k] + 1 : last;
    }
    return any != 0;
}

TERRAY_SIMD_CLONES
void mixIn(const Floats& coarser, const Floats& coarse, Floats& open) {
    for (int k = 0; k < kBatch; ++k) open[k] += coarser[k] * (coarse[k] - open[k]);
}

TERRAY_SIMD_CLONES
void blendSky(const SkyCells& c, Floats& open) {
    for (int k = 0; k < kBatch; ++k) {
        const auto top = static_cast<int32_t>(c.posts[k]);
        const auto bottom = static_cast<int32_t>(c.posts[k] >> 32);
        const float u = c.u[k], v = c.v[k];
        const float upper = static_cast<float>(top & 0xFFFF) * (1 - u) +
                            static_cast<float>((top >> 16) & 0xFFFF) * u;
        const float lower = static_cast<float>(bottom & 0xFFFF) * (1 - u) +
                            static_cast<float>((bottom >> 16) & 0xFFFF) * u;
        open[k] = (upper * (1 - v) + lower * v) * (1.0f / kCodes);
    }
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
    overview.heights = {};
    finest.open.resize(open.size());
    for (size_t k = 0; k < open.size(); ++k)
        finest.open[k] = static_cast<uint16_t>(std::clamp(open[k], 0.0f, 1.0f) * kCodes + 0.5f);
    mips_.push_back(std::move(finest));
    while (mips_.back().width >= 4 && mips_.back().height >= 4)
        mips_.push_back(halve(mips_.back()));
    finest_ = overview.mip;
    for (const Mip& mip : mips_) posts_.push_back(mip.open.data());
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

void SkyLight::readMips(const Ints& mip, const Places& places, Floats& open) const {
    SkyCells cells;
    locateSky(mip, mips_[0].width, mips_[0].height, finest_, places, cells);
    const uint16_t* const* posts = posts_.data();
    for (int k = 0; k < kBatch; ++k) {
        const uint16_t* first = posts[mip[k]] + cells.first[k];
        cells.posts[k] = fourCodes(first, first + cells.width[k]);
    }
    blendSky(cells, open);
}

void SkyLight::at(const Places& places, const Floats& footprint, Floats& open) const {
    const int last = static_cast<int>(mips_.size()) - 1;
    Ints mip;
    Floats coarser, coarse;
    chooseSkyMips(footprint, static_cast<float>(mips_[0].scale), last, mip, coarser);
    readMips(mip, places, open);
    if (!nextMips(coarser, last, mip)) return;
    readMips(mip, places, coarse);
    mixIn(coarser, coarse, open);
}

float SkyLight::at(double i, double j, float footprint) const {
    const float posts = footprint * static_cast<float>(mips_[0].scale);
    const rules::MipBlend blend = rules::mipBlend(posts, static_cast<int>(mips_.size()) - 1);
    const float fine = mips_[static_cast<size_t>(blend.mip)].at(i, j);
    if (blend.coarser <= 0) return fine;
    return fine + blend.coarser * (mips_[static_cast<size_t>(blend.mip) + 1].at(i, j) - fine);
}

}  // namespace terray
