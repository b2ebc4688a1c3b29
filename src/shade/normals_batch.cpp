// SPDX-License-Identifier: Apache-2.0
// Filtered gradients in batches: where the 4 x 4 posts lie in one tile and none is a hole, which is
// nearly everywhere, they are fetched row by row and weighed in SIMD loops; elsewhere one by one.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/simd_clones.h"
#include "kernel/height.h"
#include "shade/normals.h"
#include "shade/rules/filter.h"
#include "shade/rules/spline.h"

namespace terray {

/// 4 x 4 posts around each place, and where the places lie in their mip.
struct FilteredGradient::Patches {
    Lanes<uint64_t> codes[4];  ///< a row of four 16-bit codes each
    Floats heights[4][4];
    Ints tileX, tileY;  ///< of the first inner post's tile
    Ints first;         ///< of the 16 posts in the tile; less than 0: not in one tile, kUnused
    Floats u, v;        ///< place between the inner posts
    Floats scale;       ///< weight, per mip-0 cell
    Floats zStep;       ///< metres of what the posts are counted in
    Floats2 gradient;   ///< what comes out, scaled
    Floats highest;     ///< code of the 16; 65535 is a hole
};

namespace {

constexpr int32_t kAcrossTiles = -1, kUnused = -2;

TERRAY_SIMD_CLONES
void chooseMips(const Floats& footprint, int last, Ints& mip, Floats& coarser, Floats& finer) {
    for (int k = 0; k < kBatch; ++k) {
        // The spline itself averages over about two cells, so the mip of half the footprint fits.
        const rules::MipBlend blend = rules::mipBlend(0.5f * footprint[k], last);
        mip[k] = blend.mip;
        coarser[k] = blend.coarser;
        finer[k] = 1.0f - blend.coarser;
    }
}

TERRAY_SIMD_CLONES
void locate(const Ints& mip, int step, const Floats& share, const Doubles& i, const Doubles& j,
            Ints& tileX, Ints& tileY, Ints& first, Floats& u, Floats& v, Floats& scale) {
    constexpr int32_t kInner = kSlotCells - 1;
    for (int k = 0; k < kBatch; ++k) {
        const float perCell = std::bit_cast<float>((127 - step - mip[k]) << 23);
        const auto cells = static_cast<double>(perCell);
        const double x = i[k] * cells, y = j[k] * cells;
        const auto column = static_cast<int32_t>(x), row = static_cast<int32_t>(y);
        u[k] = static_cast<float>(x - static_cast<double>(column));
        v[k] = static_cast<float>(y - static_cast<double>(row));
        scale[k] = perCell * share[k];
        tileX[k] = column >> kTileLevels;
        tileY[k] = row >> kTileLevels;
        const int32_t inX = column & kInner, inY = row & kInner;
        const bool border = (inX == 0) | (inX == kInner) | (inY == 0) | (inY == kInner);
        const int32_t post = (inY - 1) * kPostStride + inX - 1;
        const int32_t fetched = border ? kAcrossTiles : post;
        first[k] = share[k] > 0.0f ? fetched : kUnused;
    }
}

TERRAY_SIMD_CLONES
void decode(const Lanes<uint64_t> (&codes)[4], Floats (&z)[4][4], Floats& highest) {
    int32_t most[kBatch] = {};
    for (int r = 0; r < 4; ++r) {
        for (int k = 0; k < kBatch; ++k) {
            const uint64_t row = codes[r][k];
            const auto low = static_cast<int32_t>(row), high = static_cast<int32_t>(row >> 32);
            const int32_t a = low & 0xFFFF, b = (low >> 16) & 0xFFFF;
            const int32_t c = high & 0xFFFF, d = (high >> 16) & 0xFFFF;
            z[r][0][k] = static_cast<float>(a);
            z[r][1][k] = static_cast<float>(b);
            z[r][2][k] = static_cast<float>(c);
            z[r][3][k] = static_cast<float>(d);
            const int32_t ab = a > b ? a : b, cd = c > d ? c : d, all = ab > cd ? ab : cd;
            most[k] = most[k] > all ? most[k] : all;
        }
    }
    for (int k = 0; k < kBatch; ++k) highest[k] = static_cast<float>(most[k]);
}

TERRAY_SIMD_CLONES
void weigh(const Floats (&z)[4][4], const Floats& u, const Floats& v, const Floats& scale,
           const Floats& zStep, Floats2& gradient) {
    for (int k = 0; k < kBatch; ++k) {
        const rules::SplineWeights across = rules::splineWeights(u[k]);
        const rules::SplineWeights down = rules::splineWeights(v[k]);
        float dzdi = 0, dzdj = 0;
        for (int r = 0; r < 4; ++r) {
            const float a = z[r][0][k], b = z[r][1][k], c = z[r][2][k], d = z[r][3][k];
            const float value = across.value[0] * a + across.value[1] * b + across.value[2] * c +
                                across.value[3] * d;
            const float slope = across.slope[0] * a + across.slope[1] * b + across.slope[2] * c +
                                across.slope[3] * d;
            dzdi += down.value[r] * slope;
            dzdj += down.slope[r] * value;
        }
        gradient.x[k] = dzdi * (scale[k] * zStep[k]);
        gradient.y[k] = dzdj * (scale[k] * zStep[k]);
    }
}

/// Adds what was weighed; lanes without it, or with holes in it, are marked in `rest`.
TERRAY_SIMD_CLONES
void addUp(const Ints& first, const Floats2& part, const Floats& highest, Floats2& sum,
           Ints& rest) {
    for (int k = 0; k < kBatch; ++k) {
        const bool used = first[k] >= 0;
        sum.x[k] += used ? part.x[k] : 0.0f;
        sum.y[k] += used ? part.y[k] : 0.0f;
        const bool hole = used & (highest[k] >= 65535.0f);
        rest[k] |= ((first[k] == kAcrossTiles) | hole) ? 1 : 0;
    }
}

/// Takes over the sums but where lanes are marked or the sum is none; true if there are such lanes.
TERRAY_SIMD_CLONES
bool keepCertain(const Floats2& sum, Ints& rest, Floats2& gradient) {
    int32_t any = 0;
    for (int k = 0; k < kBatch; ++k) {
        const float x = sum.x[k], y = sum.y[k];
        const int32_t marked = rest[k] | (x != x ? 1 : 0) | (y != y ? 1 : 0);
        gradient.x[k] = marked ? gradient.x[k] : x;
        gradient.y[k] = marked ? gradient.y[k] : y;
        rest[k] = marked;
        any |= marked;
    }
    return any != 0;
}

TERRAY_SIMD_CLONES
bool isAllZero(const Floats& share) {
    int32_t some = 0;
    for (int k = 0; k < kBatch; ++k) some |= share[k] > 0.0f ? 1 : 0;
    return some == 0;
}

}  // namespace

/// Fetches the posts of the places that need them.
void FilteredGradient::fetch(const Ints& mip, int step, Patches& p) const {
    int32_t lastMip = -1, tileX = 0, tileY = 0;
    int32_t lastX = 0, lastY = 0;  // the last first posts that have three more; else whole tiles
    bool whole = true;
    uint64_t base = 0;
    float zStep = 1;
    for (int k = 0; k < kBatch; ++k) {
        if (p.first[k] < 0) continue;
        if (mip[k] != lastMip || p.tileX[k] != tileX || p.tileY[k] != tileY) {
            lastMip = mip[k], tileX = p.tileX[k], tileY = p.tileY[k];
            const int m = lastMip + step;
            const uint32_t slot = slotAt(cut_, m, int64_t{tileX} << (m + kTileLevels),
                                         int64_t{tileY} << (m + kTileLevels));
            const auto lastPost = [&](int64_t posts, int64_t tile) {
                return static_cast<int32_t>(
                    std::min<int64_t>(posts - tile * kSlotCells - 4, kSlotCells));
            };
            lastX = slot == kNoSlot ? -1 : lastPost(columns_[m], tileX);
            lastY = slot == kNoSlot ? -1 : lastPost(rows_[m], tileY);
            whole = std::min(lastX, lastY) >= kSlotCells - 3;
            base = slot == kNoSlot ? 0 : cut_.tiles[slot].posts;
            if (cut_.format == 0 && slot != kNoSlot) zStep = cut_.tiles[slot].zStep;
        }
        const int32_t first = p.first[k];
        if (!whole && (first % kPostStride > lastX || first / kPostStride > lastY)) {
            p.first[k] = kAcrossTiles;
            continue;
        }
        p.zStep[k] = zStep;
        if (cut_.format == 0) {
            const uint16_t* codes = static_cast<const uint16_t*>(cut_.posts) + base + first;
            for (int r = 0; r < 4; ++r, codes += kPostStride)
                std::memcpy(&p.codes[r][k], codes, sizeof(uint64_t));
        } else {
            const float* posts = static_cast<const float*>(cut_.posts) + base + first;
            for (int r = 0; r < 4; ++r, posts += kPostStride)
                for (int c = 0; c < 4; ++c) p.heights[r][c][k] = posts[c];
        }
    }
}

void FilteredGradient::at(const Doubles& i, const Doubles& j, const Floats& footprint,
                          Floats2& gradient) const {
    static thread_local Patches patches;
    Ints mip, rest{};
    Floats coarser, finer;
    Floats2 sum{};
    chooseMips(footprint, maxMip_, mip, coarser, finer);
    for (const int step : {0, 1}) {
        const Floats& share = step ? coarser : finer;
        if (isAllZero(share)) continue;
        locate(mip, step, share, i, j, patches.tileX, patches.tileY, patches.first, patches.u,
               patches.v, patches.scale);
        fetch(mip, step, patches);
        if (cut_.format == 0) decode(patches.codes, patches.heights, patches.highest);
        weigh(patches.heights, patches.u, patches.v, patches.scale, patches.zStep,
              patches.gradient);
        addUp(patches.first, patches.gradient, patches.highest, sum, rest);
    }
    if (!keepCertain(sum, rest, gradient)) return;
    for (int k = 0; k < kBatch; ++k) {
        if (!rest[k]) continue;
        glm::vec2 g{gradient.x[k], gradient.y[k]};
        at(i[k], j[k], footprint[k], g);
        gradient.x[k] = g.x;
        gradient.y[k] = g.y;
    }
}

}  // namespace terray
