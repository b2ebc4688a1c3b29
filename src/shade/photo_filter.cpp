// SPDX-License-Identifier: Apache-2.0
// Builds the photo's mips (averages of light, weighed by cover) and takes the anisotropic taps.
#include "shade/photo_filter.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "shade/rules/filter.h"

namespace terray {
namespace {

constexpr int kMostTaps = 8;

struct CodeTables {
    std::array<float, 256> linear{}, share{};
    std::array<uint8_t, 8192> code{};
    CodeTables() {
        for (size_t k = 0; k < 256; ++k) {
            linear[k] = rules::linearFromSrgb(static_cast<float>(k) / 255.0f);
            share[k] = static_cast<float>(k) / 255.0f;
        }
        for (size_t k = 0; k < code.size(); ++k) {
            const float v = static_cast<float>(k) / static_cast<float>(code.size() - 1);
            code[k] = static_cast<uint8_t>(std::lround(255.0f * rules::srgbFromLinear(v)));
        }
    }
    uint8_t codeOf(float v) const {
        const float x = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(code.size() - 1);
        return code[static_cast<size_t>(x + 0.5f)];
    }
};
const CodeTables kTables;

const uint8_t* pixelAt(const uint8_t* rgba, int width, int x, int y) {
    return rgba +
           (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * 4;
}

/// Mean of the fine pixels under one coarse pixel, as far as they exist.
void averagePixels(const uint8_t* fine, int width, int height, int x, int y, uint8_t* out) {
    float sum[4] = {0, 0, 0, 0}, count = 0;
    for (int dy = 0; dy < 2 && 2 * y + dy < height; ++dy) {
        for (int dx = 0; dx < 2 && 2 * x + dx < width; ++dx) {
            const uint8_t* p = pixelAt(fine, width, 2 * x + dx, 2 * y + dy);
            const float share = kTables.share[p[3]];
            for (int c = 0; c < 3; ++c) sum[c] += share * kTables.linear[p[c]];
            sum[3] += share;
            count += 1;
        }
    }
    const float toStraight = sum[3] > 0 ? 1.0f / sum[3] : 0.0f;
    for (int c = 0; c < 3; ++c) out[c] = kTables.codeOf(sum[c] * toStraight);
    out[3] = static_cast<uint8_t>(std::lround(255.0f * sum[3] / count));
}

}  // namespace

PhotoFilter::Mip PhotoFilter::halve(const Mip& fine) {
    Mip coarse;
    coarse.width = (fine.width + 1) / 2;
    coarse.height = (fine.height + 1) / 2;
    coarse.scale = fine.scale * 0.5f;
    coarse.own.resize(static_cast<size_t>(coarse.width) * static_cast<size_t>(coarse.height) * 4);
    oneapi::tbb::parallel_for(0, coarse.height, [&](int y) {
        for (int x = 0; x < coarse.width; ++x) {
            const size_t at =
                static_cast<size_t>(y) * static_cast<size_t>(coarse.width) + static_cast<size_t>(x);
            averagePixels(fine.rgba, fine.width, fine.height, x, y, &coarse.own[4 * at]);
        }
    });
    coarse.rgba = coarse.own.data();
    return coarse;
}

PhotoFilter::PhotoFilter(const Photo& photo) : width_(photo.width), height_(photo.height) {
    Mip finest;
    finest.width = photo.width;
    finest.height = photo.height;
    finest.rgba = photo.rgba.data();
    mips_.push_back(std::move(finest));
    while (mips_.back().width > 1 || mips_.back().height > 1) mips_.push_back(halve(mips_.back()));
}

void PhotoFilter::addTap(const Mip& mip, Vec2 place, float weight, PhotoSample& sum) const {
    const double x = (place.x + 0.5) * static_cast<double>(mip.scale) - 0.5;
    const double y = (place.y + 0.5) * static_cast<double>(mip.scale) - 0.5;
    const double left = std::floor(x), top = std::floor(y);
    const float fx = static_cast<float>(x - left), fy = static_cast<float>(y - top);
    const int x0 = static_cast<int>(left), y0 = static_cast<int>(top);
    const int columns[2] = {std::clamp(x0, 0, mip.width - 1), std::clamp(x0 + 1, 0, mip.width - 1)};
    const int rows[2] = {std::clamp(y0, 0, mip.height - 1), std::clamp(y0 + 1, 0, mip.height - 1)};
    const float across[2] = {1.0f - fx, fx}, down[2] = {weight * (1.0f - fy), weight * fy};
    for (int r = 0; r < 2; ++r) {
        for (int c = 0; c < 2; ++c) {
            const uint8_t* p = pixelAt(mip.rgba, mip.width, columns[c], rows[r]);
            const float share = down[r] * across[c] * kTables.share[p[3]];
            sum.colour.r += share * kTables.linear[p[0]];
            sum.colour.g += share * kTables.linear[p[1]];
            sum.colour.b += share * kTables.linear[p[2]];
            sum.cover += share;
        }
    }
}

PhotoSample PhotoFilter::at(Vec2 place, glm::vec2 a, glm::vec2 b) const {
    const float lengthA = glm::length(a), lengthB = glm::length(b);
    const glm::vec2 axis = lengthA >= lengthB ? a : b;
    const float major = std::max(std::max(lengthA, lengthB), 1e-6f);
    const float area = std::abs(a.x * b.y - a.y * b.x);
    const float minor = std::clamp(area / major, major / kMostTaps, major);
    const int taps = major <= 1.0f ? 1 : static_cast<int>(std::ceil(major / minor - 0.25f));
    const rules::MipBlend blend =
        rules::mipBlend(std::max(minor, 1.0f), static_cast<int>(mips_.size()) - 1);
    const auto mip = static_cast<size_t>(blend.mip);
    PhotoSample sum;
    const float weight = 1.0f / static_cast<float>(taps);
    for (int k = 0; k < taps; ++k) {
        const float along = (static_cast<float>(k) + 0.5f) * weight - 0.5f;
        const Vec2 tap =
            place + Vec2{static_cast<double>(along * axis.x), static_cast<double>(along * axis.y)};
        // Half a pixel of grace: a photo that ends with the posts' pixels covers the posts.
        if (tap.x < -1 || tap.y < -1 || tap.x > width_ || tap.y > height_) continue;
        if (blend.coarser < 1.0f) addTap(mips_[mip], tap, weight * (1.0f - blend.coarser), sum);
        if (blend.coarser > 0.0f) addTap(mips_[mip + 1], tap, weight * blend.coarser, sum);
    }
    return sum;
}

}  // namespace terray
