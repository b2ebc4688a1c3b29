// SPDX-License-Identifier: Apache-2.0
// Builds the photo's mips (averages of light, weighed by cover) and takes the anisotropic taps.
#include "shade/photo_filter.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/simd_clones.h"
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

/// Adds the four pixels around a place.
inline void PhotoFilter::addTap(const Mip& mip, double placeX, double placeY, float weight,
                                PhotoSample& sum) {
    constexpr int kBefore = 2;  // places begin at -1: whole parts by truncation, not by floor
    const double x = (placeX + 0.5) * static_cast<double>(mip.scale) + (kBefore - 0.5);
    const double y = (placeY + 0.5) * static_cast<double>(mip.scale) + (kBefore - 0.5);
    const int wholeX = static_cast<int>(x), wholeY = static_cast<int>(y);
    const float u = static_cast<float>(x - wholeX), v = static_cast<float>(y - wholeY);
    const int x0 = std::clamp(wholeX - kBefore, 0, mip.width - 1);
    const int y0 = std::clamp(wholeY - kBefore, 0, mip.height - 1);
    const int x1 = std::clamp(wholeX + 1 - kBefore, 0, mip.width - 1);
    const int y1 = std::clamp(wholeY + 1 - kBefore, 0, mip.height - 1);
    const uint8_t* topLeft = pixelAt(mip.rgba, mip.width, x0, y0);
    const ptrdiff_t right = 4 * static_cast<ptrdiff_t>(x1 - x0);
    const ptrdiff_t down = 4 * static_cast<ptrdiff_t>(y1 - y0) * mip.width;
    const auto add = [&](const uint8_t* p, float pixelWeight) {
        const float share = pixelWeight * kTables.share[p[3]];
        sum.colour.r += share * kTables.linear[p[0]];
        sum.colour.g += share * kTables.linear[p[1]];
        sum.colour.b += share * kTables.linear[p[2]];
        sum.cover += share;
    };
    const float upper = weight * (1.0f - v), lower = weight * v;
    add(topLeft, upper * (1.0f - u));
    add(topLeft + right, upper * u);
    add(topLeft + down, lower * (1.0f - u));
    add(topLeft + down + right, lower * u);
}

/// How the taps of a batch lie: along an axis, in one mip or two.
struct PhotoFilter::Shapes {
    Floats2 axis;
    Floats perTap;  ///< weight of a tap
    Floats coarser;
    Ints taps, mip;
};

namespace {

TERRAY_SIMD_CLONES
void chooseTaps(const Floats2& a, const Floats2& b, int last, Floats2& axis, Floats& perTap,
                Floats& coarser, Ints& taps, Ints& mip) {
    for (int k = 0; k < kBatch; ++k) {
        const float ax = a.x[k], ay = a.y[k], bx = b.x[k], by = b.y[k];
        const float lengthA = ax * ax + ay * ay, lengthB = bx * bx + by * by;
        const bool alongA = lengthA >= lengthB;
        axis.x[k] = alongA ? ax : bx;
        axis.y[k] = alongA ? ay : by;
        const float length = std::sqrt(alongA ? lengthA : lengthB);
        const float major = length > 1e-6f ? length : 1e-6f;
        const float across = std::abs(ax * by - ay * bx) / major,
                    least = major * (1.0f / kMostTaps);
        const float wide = across > least ? across : least;
        const float minor = wide < major ? wide : major;
        const float wanted = major / minor - 0.25f;
        const auto whole = static_cast<int32_t>(wanted);
        const int32_t many = whole + (wanted > static_cast<float>(whole) ? 1 : 0);
        taps[k] = major <= 1.0f ? 1 : many;
        perTap[k] = 1.0f / static_cast<float>(taps[k]);
        const rules::MipBlend blend = rules::mipBlend(minor > 1.0f ? minor : 1.0f, last);
        mip[k] = blend.mip;
        coarser[k] = blend.coarser;
    }
}

}  // namespace

void PhotoFilter::at(const PhotoFeet& feet, PhotoBatch& photo) const {
    Shapes s;
    chooseTaps(feet.a, feet.b, static_cast<int>(mips_.size()) - 1, s.axis, s.perTap, s.coarser,
               s.taps, s.mip);
    for (int k = 0; k < kBatch; ++k) {
        const Mip& fine = mips_[static_cast<size_t>(s.mip[k])];
        const float coarse = s.perTap[k] * s.coarser[k], own = s.perTap[k] - coarse;
        PhotoSample sum;
        for (int n = 0; n < s.taps[k]; ++n) {
            const float along = (static_cast<float>(n) + 0.5f) * s.perTap[k] - 0.5f;
            const double x = feet.x[k] + static_cast<double>(along * s.axis.x[k]);
            const double y = feet.y[k] + static_cast<double>(along * s.axis.y[k]);
            // Half a pixel of grace: a photo that ends with the posts' pixels covers the posts.
            if (x < -1 || y < -1 || x > width_ || y > height_) continue;
            if (own > 0.0f) addTap(fine, x, y, own, sum);
            if (coarse > 0.0f) addTap(*(&fine + 1), x, y, coarse, sum);
        }
        photo.colour.r[k] = sum.colour.r;
        photo.colour.g[k] = sum.colour.g;
        photo.colour.b[k] = sum.colour.b;
        photo.cover[k] = sum.cover;
    }
}

PhotoSample PhotoFilter::at(Vec2 place, glm::vec2 a, glm::vec2 b) const {
    PhotoFeet feet;
    PhotoBatch photo;
    for (int k = 0; k < kBatch; ++k) {
        feet.x[k] = place.x;
        feet.y[k] = place.y;
        feet.a.x[k] = a.x;
        feet.a.y[k] = a.y;
        feet.b.x[k] = b.x;
        feet.b.y[k] = b.y;
    }
    at(feet, photo);
    return {{photo.colour.r[0], photo.colour.g[0], photo.colour.b[0]}, photo.cover[0]};
}

}  // namespace terray
