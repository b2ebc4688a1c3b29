// SPDX-License-Identifier: Apache-2.0
// Builds the photo's mips (averages of light, weighed by cover) and takes the anisotropic taps.
#include "shade/photo_filter.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/assert.h"
#include "base/simd_clones.h"
#include "kernel/layout/layout.h"
#include "shade/rules/filter.h"
#include "tile/photo_mips.h"

namespace terray {
namespace {

constexpr int kMostTaps = 8;

struct CodeTables {
    std::array<float, 256> linear{}, share{};
    CodeTables() {
        for (size_t k = 0; k < 256; ++k) {
            linear[k] = rules::linearFromSrgb(static_cast<float>(k) / 255.0f);
            share[k] = static_cast<float>(k) / 255.0f;
        }
    }
};
const CodeTables kTables;

const uint8_t* pixelAt(const uint8_t* rgba, int width, int x, int y) {
    return rgba +
           (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) * 4;
}

}  // namespace

PhotoFilter::Mip PhotoFilter::halve(const Mip& fine) {
    Mip coarse;
    coarse.width = (fine.width + 1) / 2;
    coarse.height = (fine.height + 1) / 2;
    coarse.scale = fine.scale * 0.5f;
    const ptrdiff_t fineStride = ptrdiff_t{fine.width} * 4, stride = ptrdiff_t{coarse.width} * 4;
    coarse.own.resize(static_cast<size_t>(coarse.height) * static_cast<size_t>(stride));
    oneapi::tbb::parallel_for(0, coarse.height, [&](int y) {
        halvePhoto(fine.rgba + 2 * y * fineStride, fine.width, std::min(2, fine.height - 2 * y),
                   fineStride, coarse.own.data() + y * stride, stride);
    });
    coarse.rgba = coarse.own.data();
    return coarse;
}

void PhotoFilter::addCoarser() {
    while (mips_.back().width > 1 || mips_.back().height > 1) mips_.push_back(halve(mips_.back()));
}

PhotoFilter::PhotoFilter(const Photo& photo) : width_(photo.width), height_(photo.height) {
    Mip finest;
    finest.width = photo.width;
    finest.height = photo.height;
    finest.rgba = photo.rgba.data();
    mips_.push_back(std::move(finest));
    addCoarser();
}

PhotoFilter::PhotoFilter(const ResidentPhoto& photo)
    : pages_(&photo.pages()),
      width_(static_cast<int>(photo.grid().columns)),
      height_(static_cast<int>(photo.grid().rows)) {
    float scale = 1;
    for (const PhotoPages::Mip& mip : pages_->mips) {
        Mip& added = mips_.emplace_back();
        added.width = mip.width;
        added.height = mip.height;
        added.scale = scale;
        added.inPages = &mip;
        scale *= 0.5f;
    }
    const int last = photo.grid().mipCount() - 1;
    Mip& coarsest = mips_.emplace_back();
    coarsest.width = static_cast<int>(photo.grid().columnsAt(last));
    coarsest.height = static_cast<int>(photo.grid().rowsAt(last));
    coarsest.scale = scale;
    coarsest.rgba = photo.coarsest().data();
    addCoarser();
}

/// The four pixels around a place: where they are, and their colours.
struct PhotoFilter::Corners {
    int x[2], y[2];
    const uint8_t* pixels[4];  ///< row by row
};

/// False where a block is missing.
inline bool PhotoFilter::findInPages(const PhotoPages::Mip& mip, Corners& corners,
                                     PhotoUse& use) const {
    constexpr int kInside = kPhotoBlockSide - 1;
    const auto numberAt = [&](int x, int y) {
        return mip.first +
               static_cast<uint32_t>((y >> kPhotoBlockLog2) * mip.blocksX + (x >> kPhotoBlockLog2));
    };
    const auto blockOf = [&](uint32_t number) -> const uint8_t* {
        const uint32_t slot = pages_->slots[number];
        if (slot == kNoSlot) {
            use.miss(number);
            return nullptr;
        }
        use.touched[slot] = 1;
        return pages_->pixels + slot * kPhotoBlockBytes;
    };
    const uint32_t first = numberAt(corners.x[0], corners.y[0]);
    const bool isOne = first == numberAt(corners.x[1], corners.y[1]);
    const uint8_t* block = isOne ? blockOf(first) : nullptr;
    if (isOne && block == nullptr) return false;
    bool all = true;
    for (int k = 0; k < 4; ++k) {
        const int x = corners.x[k & 1], y = corners.y[k >> 1];
        if (!isOne) block = blockOf(numberAt(x, y));
        all = all && block != nullptr;
        if (block != nullptr)
            corners.pixels[k] = pixelAt(block, kPhotoBlockSide, x & kInside, y & kInside);
    }
    return all;
}

/// Adds the four pixels around a place; of a coarser mip where a block of this one is missing.
template <bool kInBlocks>
inline void PhotoFilter::addTap(const Mip* mip, double placeX, double placeY, float weight,
                                PhotoSample& sum, PhotoUse& use) const {
    constexpr int kBefore = 2;  // places begin at -1: whole parts by truncation, not by floor
    Corners corners;
    float u = 0, v = 0;
    for (;; ++mip) {
        const double x = (placeX + 0.5) * static_cast<double>(mip->scale) + (kBefore - 0.5);
        const double y = (placeY + 0.5) * static_cast<double>(mip->scale) + (kBefore - 0.5);
        const int wholeX = static_cast<int>(x), wholeY = static_cast<int>(y);
        u = static_cast<float>(x - wholeX), v = static_cast<float>(y - wholeY);
        for (int k = 0; k < 2; ++k) {
            corners.x[k] = std::clamp(wholeX + k - kBefore, 0, mip->width - 1);
            corners.y[k] = std::clamp(wholeY + k - kBefore, 0, mip->height - 1);
        }
        if (!kInBlocks || mip->rgba != nullptr) {
            const uint8_t* topLeft = pixelAt(mip->rgba, mip->width, corners.x[0], corners.y[0]);
            const ptrdiff_t right = 4 * static_cast<ptrdiff_t>(corners.x[1] - corners.x[0]);
            const ptrdiff_t down =
                4 * static_cast<ptrdiff_t>(corners.y[1] - corners.y[0]) * mip->width;
            corners.pixels[0] = topLeft;
            corners.pixels[1] = topLeft + right;
            corners.pixels[2] = topLeft + down;
            corners.pixels[3] = topLeft + down + right;
            break;
        }
        if (findInPages(*mip->inPages, corners, use)) break;
    }
    const auto add = [&](const uint8_t* p, float pixelWeight) {
        const float share = pixelWeight * kTables.share[p[3]];
        sum.colour.r += share * kTables.linear[p[0]];
        sum.colour.g += share * kTables.linear[p[1]];
        sum.colour.b += share * kTables.linear[p[2]];
        sum.cover += share;
    };
    const float upper = weight * (1.0f - v), lower = weight * v;
    add(corners.pixels[0], upper * (1.0f - u));
    add(corners.pixels[1], upper * u);
    add(corners.pixels[2], lower * (1.0f - u));
    add(corners.pixels[3], lower * u);
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

template <bool kInBlocks>
void PhotoFilter::takeTaps(const PhotoFeet& feet, const Shapes& s, PhotoBatch& photo,
                           PhotoUse& use) const {
    for (int k = 0; k < kBatch; ++k) {
        const Mip& fine = mips_[static_cast<size_t>(s.mip[k])];
        const float coarse = s.perTap[k] * s.coarser[k], own = s.perTap[k] - coarse;
        PhotoSample sum;
        const uint64_t missesBefore = use.misses;
        for (int n = 0; n < s.taps[k]; ++n) {
            const float along = (static_cast<float>(n) + 0.5f) * s.perTap[k] - 0.5f;
            const double x = feet.x[k] + static_cast<double>(along * s.axis.x[k]);
            const double y = feet.y[k] + static_cast<double>(along * s.axis.y[k]);
            // Half a pixel of grace: a photo that ends with the posts' pixels covers the posts.
            if (x < -1 || y < -1 || x > width_ || y > height_) continue;
            if (own > 0.0f) addTap<kInBlocks>(&fine, x, y, own, sum, use);
            if (coarse > 0.0f) addTap<kInBlocks>(&fine + 1, x, y, coarse, sum, use);
        }
        photo.late[k] = kInBlocks && use.misses != missesBefore ? 1 : 0;
        photo.colour.r[k] = sum.colour.r;
        photo.colour.g[k] = sum.colour.g;
        photo.colour.b[k] = sum.colour.b;
        photo.cover[k] = sum.cover;
    }
}

void PhotoFilter::at(const PhotoFeet& feet, PhotoBatch& photo, PhotoUse& use) const {
    TERRAY_ASSERT(pages_ == nullptr || use.touched.size() == pages_->slotCount);
    Shapes shapes;
    chooseTaps(feet.a, feet.b, static_cast<int>(mips_.size()) - 1, shapes.axis, shapes.perTap,
               shapes.coarser, shapes.taps, shapes.mip);
    if (pages_ != nullptr)
        takeTaps<true>(feet, shapes, photo, use);
    else
        takeTaps<false>(feet, shapes, photo, use);
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
    PhotoUse unused;
    prepare(unused);
    at(feet, photo, unused);
    return {{photo.colour.r[0], photo.colour.g[0], photo.colour.b[0]}, photo.cover[0]};
}

}  // namespace terray
