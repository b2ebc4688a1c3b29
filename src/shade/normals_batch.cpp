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
void locate(const Ints& mip, int step, const Floats& share, const Places& places, Ints& tileX,
            Ints& tileY, Ints& first, Floats& u, Floats& v, Floats& scale) {
    constexpr int32_t kInner = kSlotCells - 1;
    for (int k = 0; k < kBatch; ++k) {
        const int32_t m = mip[k] + step;
        const float perCell = std::bit_cast<float>((127 - m) << 23);
        const int32_t x = places.x[k], y = places.y[k], within = (1 << m) - 1;
        const float inX0 = (static_cast<float>(x & within) + places.dx[k]) * perCell;
        const float inY0 = (static_cast<float>(y & within) + places.dy[k]) * perCell;
        const auto aheadX = static_cast<int32_t>(inX0), aheadY = static_cast<int32_t>(inY0);
        const int32_t column = (x >> m) + aheadX, row = (y >> m) + aheadY;
        u[k] = inX0 - static_cast<float>(aheadX);
        v[k] = inY0 - static_cast<float>(aheadY);
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

/// Gradient of a row of four posts after the other, by spline weights.
struct Weighing {
    rules::SplineWeights across, down;
    float dzdi = 0, dzdj = 0;
    Weighing(float u, float v) : across(rules::splineWeights(u)), down(rules::splineWeights(v)) {}
    void add(int r, float a, float b, float c, float d) {
        const float value =
            across.value[0] * a + across.value[1] * b + across.value[2] * c + across.value[3] * d;
        const float slope =
            across.slope[0] * a + across.slope[1] * b + across.slope[2] * c + across.slope[3] * d;
        dzdi += down.value[r] * slope;
        dzdj += down.slope[r] * value;
    }
};

/// Adds to the sums of the lanes that have posts. Those that have some elsewhere, or holes among
/// them, are marked in `rest`.
TERRAY_SIMD_CLONES
void weighCodes(const Lanes<uint64_t> (&codes)[4], const Ints& first, const Floats& u,
                const Floats& v, const Floats& scale, const Floats& zStep, Floats2& gradient,
                Ints& rest) {
#if !defined(__clang__)
#pragma GCC ivdep
#endif
    for (int k = 0; k < kBatch; ++k) {
        Weighing sum(u[k], v[k]);
        int32_t most = 0;
        for (int r = 0; r < 4; ++r) {
            const uint64_t row = codes[r][k];
            const auto low = static_cast<int32_t>(row), high = static_cast<int32_t>(row >> 32);
            const int32_t a = low & 0xFFFF, b = (low >> 16) & 0xFFFF;
            const int32_t c = high & 0xFFFF, d = (high >> 16) & 0xFFFF;
            const int32_t ab = a > b ? a : b, cd = c > d ? c : d, all = ab > cd ? ab : cd;
            most = most > all ? most : all;
            sum.add(r, static_cast<float>(a), static_cast<float>(b), static_cast<float>(c),
                    static_cast<float>(d));
        }
        const bool used = first[k] >= 0, hole = used & (most == 0xFFFF);
        const float metres = scale[k] * zStep[k];
        gradient.x[k] += used ? sum.dzdi * metres : 0.0f;
        gradient.y[k] += used ? sum.dzdj * metres : 0.0f;
        rest[k] |= ((first[k] == kAcrossTiles) | hole) ? 1 : 0;
    }
}

TERRAY_SIMD_CLONES
void weighHeights(const Floats (&z)[4][4], const Ints& first, const Floats& u, const Floats& v,
                  const Floats& scale, Floats2& gradient, Ints& rest) {
#if !defined(__clang__)
#pragma GCC ivdep
#endif
    for (int k = 0; k < kBatch; ++k) {
        Weighing sum(u[k], v[k]);
        for (int r = 0; r < 4; ++r) sum.add(r, z[r][0][k], z[r][1][k], z[r][2][k], z[r][3][k]);
        const bool used = first[k] >= 0;
        gradient.x[k] += used ? sum.dzdi * scale[k] : 0.0f;
        gradient.y[k] += used ? sum.dzdj * scale[k] : 0.0f;
        rest[k] |= first[k] == kAcrossTiles ? 1 : 0;
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
bool allLike(const Ints& mip, const Ints& tileX, const Ints& tileY, const Ints& first, int lane) {
    const int32_t m = mip[lane], x = tileX[lane], y = tileY[lane];
    int32_t unlike = 0;
    for (int k = 0; k < kBatch; ++k) {
        const int32_t differs = (mip[k] ^ m) | (tileX[k] ^ x) | (tileY[k] ^ y);
        unlike |= first[k] < 0 ? 0 : differs;
    }
    return unlike == 0;
}

/// True if all places that fetch posts do so from one tile; `lane` is one of them.
bool areAlike(const Ints& mip, const Ints& tileX, const Ints& tileY, const Ints& first, int& lane) {
    lane = 0;
    while (lane < kBatch && first[lane] < 0) ++lane;
    return lane < kBatch && allLike(mip, tileX, tileY, first, lane);
}

TERRAY_SIMD_CLONES
bool isAllZero(const Floats& share) {
    int32_t some = 0;
    for (int k = 0; k < kBatch; ++k) some |= share[k] > 0.0f ? 1 : 0;
    return some == 0;
}

}  // namespace

/// The tile that posts were last fetched from.
struct FilteredGradient::LastTile {
    int32_t mip = -1, x = 0, y = 0;
    int32_t lastX = 0, lastY = 0;  ///< the last first posts that have three more; else whole tiles
    bool whole = true;
    uint64_t posts = 0;
    float zStep = 1;
};

void FilteredGradient::enter(int mip, int32_t x, int32_t y, LastTile& tile) const {
    tile.mip = mip, tile.x = x, tile.y = y;
    const uint32_t slot =
        slotAt(cut_, mip, int64_t{x} << (mip + kTileLevels), int64_t{y} << (mip + kTileLevels));
    const auto lastPost = [&](int64_t posts, int64_t at) {
        return static_cast<int32_t>(std::min<int64_t>(posts - at * kSlotCells - 4, kSlotCells));
    };
    tile.lastX = slot == kNoSlot ? -1 : lastPost(columns_[mip], x);
    tile.lastY = slot == kNoSlot ? -1 : lastPost(rows_[mip], y);
    tile.whole = std::min(tile.lastX, tile.lastY) >= kSlotCells - 3;
    tile.posts = slot == kNoSlot ? 0 : cut_.tiles[slot].posts;
    if (cut_.format == 0 && slot != kNoSlot) tile.zStep = cut_.tiles[slot].zStep;
}

/// Fetches the posts of the places that need them.
void FilteredGradient::fetch(const Ints& mip, int step, Patches& p) const {
    LastTile tile;
    const auto fetchAt = [&](int k, int32_t first) {
        if (cut_.format == 0) {
            const uint16_t* codes = static_cast<const uint16_t*>(cut_.posts) + tile.posts + first;
            for (int r = 0; r < 4; ++r, codes += kPostStride)
                std::memcpy(&p.codes[r][k], codes, sizeof(uint64_t));
        } else {
            const float* posts = static_cast<const float*>(cut_.posts) + tile.posts + first;
            for (int r = 0; r < 4; ++r, posts += kPostStride)
                for (int c = 0; c < 4; ++c) p.heights[r][c][k] = posts[c];
        }
    };
    int lane = 0;
    if (areAlike(mip, p.tileX, p.tileY, p.first, lane)) {
        enter(mip[lane] + step, p.tileX[lane], p.tileY[lane], tile);
        if (tile.whole) {
            std::fill_n(p.zStep.at, kBatch, tile.zStep);
            // Those that need none read the tile's first.
            for (int k = 0; k < kBatch; ++k) fetchAt(k, std::max(p.first[k], 0));
            return;
        }
    }
    for (int k = 0; k < kBatch; ++k) {
        if (p.first[k] < 0) continue;
        if (mip[k] + step != tile.mip || p.tileX[k] != tile.x || p.tileY[k] != tile.y)
            enter(mip[k] + step, p.tileX[k], p.tileY[k], tile);
        const int32_t first = p.first[k];
        if (!tile.whole && (first % kPostStride > tile.lastX || first / kPostStride > tile.lastY)) {
            p.first[k] = kAcrossTiles;
            continue;
        }
        p.zStep[k] = tile.zStep;
        fetchAt(k, first);
    }
}

void FilteredGradient::at(const Places& places, const Floats& footprint, Floats2& gradient) const {
    static thread_local Patches patches;
    Ints mip, rest{};
    Floats coarser, finer;
    Floats2 sum{};
    chooseMips(footprint, maxMip_, mip, coarser, finer);
    for (const int step : {0, 1}) {
        const Floats& share = step ? coarser : finer;
        if (isAllZero(share)) continue;
        locate(mip, step, share, places, patches.tileX, patches.tileY, patches.first, patches.u,
               patches.v, patches.scale);
        fetch(mip, step, patches);
        if (cut_.format == 0)
            weighCodes(patches.codes, patches.first, patches.u, patches.v, patches.scale,
                       patches.zStep, sum, rest);
        else
            weighHeights(patches.heights, patches.first, patches.u, patches.v, patches.scale, sum,
                         rest);
    }
    if (!keepCertain(sum, rest, gradient)) return;
    for (int k = 0; k < kBatch; ++k) {
        if (!rest[k]) continue;
        glm::vec2 g{gradient.x[k], gradient.y[k]};
        at(places.i(k), places.j(k), footprint[k], g);
        gradient.x[k] = g.x;
        gradient.y[k] = g.y;
    }
}

}  // namespace terray
