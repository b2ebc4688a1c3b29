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

/// 4 x 4 posts each around up to kBatch places: 16-bit codes two a word, or floats.
struct FilteredGradient::Patches {
    Lanes<uint32_t> codes[4][2];  ///< rows; columns 0, 1 and columns 2, 3
    Floats heights[4][4];
    Floats u, v;          ///< place between the inner posts
    Floats scale;         ///< weight, per mip-0 cell, of what the posts are counted in
    Lanes<uint8_t> lane;  ///< of the batch
    Floats2 gradient;     ///< what comes out, scaled
    int count = 0;
};

namespace {

/// Where a place lies in its mip.
struct MipPlaces {
    Ints column, row;
    Floats u, v, perCell;
};

TERRAY_SIMD_CLONES
void chooseMips(const Floats& footprint, int last, Ints& mip, Floats& coarser) {
    for (int k = 0; k < kBatch; ++k) {
        // The spline itself averages over about two cells, so the mip of half the footprint fits.
        const rules::MipBlend blend = rules::mipBlend(0.5f * footprint[k], last);
        mip[k] = blend.mip;
        coarser[k] = blend.coarser;
    }
}

TERRAY_SIMD_CLONES
void locate(const Ints& mip, const Doubles& i, const Doubles& j, MipPlaces& p) {
    for (int k = 0; k < kBatch; ++k) {
        p.perCell[k] = std::bit_cast<float>((127 - mip[k]) << 23);
        const auto cells = static_cast<double>(p.perCell[k]);
        const double x = i[k] * cells, y = j[k] * cells;
        p.column[k] = static_cast<int32_t>(x);
        p.row[k] = static_cast<int32_t>(y);
        p.u[k] = static_cast<float>(x - static_cast<double>(p.column[k]));
        p.v[k] = static_cast<float>(y - static_cast<double>(p.row[k]));
    }
}

TERRAY_SIMD_CLONES
void decode(const Lanes<uint32_t> (&codes)[4][2], Floats (&z)[4][4], Floats& highest) {
    for (int k = 0; k < kBatch; ++k) highest[k] = 0.0f;
    for (int r = 0; r < 4; ++r) {
        for (int half = 0; half < 2; ++half) {
            const Lanes<uint32_t>& words = codes[r][half];
            Floats &first = z[r][2 * half], &second = z[r][2 * half + 1];
            for (int k = 0; k < kBatch; ++k) {
                const auto word = static_cast<int32_t>(words[k]);
                const auto a = static_cast<float>(word & 0xFFFF);
                const auto b = static_cast<float>((word >> 16) & 0xFFFF);
                first[k] = a;
                second[k] = b;
                const float most = a > b ? a : b;
                highest[k] = highest[k] > most ? highest[k] : most;
            }
        }
    }
}

TERRAY_SIMD_CLONES
void weigh(const Floats (&z)[4][4], const Floats& u, const Floats& v, const Floats& scale,
           Floats2& gradient) {
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
        gradient.x[k] = dzdi * scale[k];
        gradient.y[k] = dzdj * scale[k];
    }
}

}  // namespace

/// Fetches the posts of the lanes that have a share; marks those whose posts are not in one tile.
void FilteredGradient::fetch(const Ints& mip, const Floats& share, const Doubles& i,
                             const Doubles& j, Patches& p, Lanes<uint8_t>& rest) const {
    MipPlaces places;
    locate(mip, i, j, places);
    int32_t lastMip = -1, tileX = 0, tileY = 0;
    uint32_t insideX = 0, insideY = 0;  // first columns and rows of posts that have three more
    uint64_t base = 0;
    float zStep = 1;
    int n = 0;
    for (int k = 0; k < kBatch; ++k) {
        if (share[k] <= 0.0f) continue;
        const int32_t column = places.column[k], row = places.row[k], m = mip[k];
        if (m != lastMip || (column >> kTileLevels) != tileX || (row >> kTileLevels) != tileY) {
            lastMip = m, tileX = column >> kTileLevels, tileY = row >> kTileLevels;
            const uint32_t slot = slotAt(cut_, m, int64_t{column} << m, int64_t{row} << m);
            const auto postsIn = [&](int64_t posts, int64_t tile) {
                const int64_t inside = std::min<int64_t>(kSlotCells + 1, posts - tile * kSlotCells);
                return static_cast<uint32_t>(std::max<int64_t>(inside - 3, 0));
            };
            insideX = slot == kNoSlot ? 0 : postsIn(columns_[m], tileX);
            insideY = slot == kNoSlot ? 0 : postsIn(rows_[m], tileY);
            base = slot == kNoSlot ? 0 : cut_.tiles[slot].posts;
            if (cut_.format == 0 && slot != kNoSlot) zStep = cut_.tiles[slot].zStep;
        }
        const auto x = static_cast<uint32_t>(column & (kSlotCells - 1)) - 1u;
        const auto y = static_cast<uint32_t>(row & (kSlotCells - 1)) - 1u;
        if (x >= insideX || y >= insideY) {
            rest[k] = 1;
            continue;
        }
        const uint64_t first = base + uint64_t{y} * kPostStride + x;
        if (cut_.format == 0) {
            const uint16_t* codes = static_cast<const uint16_t*>(cut_.posts) + first;
            for (int r = 0; r < 4; ++r, codes += kPostStride) {
                std::memcpy(&p.codes[r][0][n], codes, sizeof(uint32_t));
                std::memcpy(&p.codes[r][1][n], codes + 2, sizeof(uint32_t));
            }
        } else {
            const float* posts = static_cast<const float*>(cut_.posts) + first;
            for (int r = 0; r < 4; ++r, posts += kPostStride)
                for (int c = 0; c < 4; ++c) p.heights[r][c][n] = posts[c];
        }
        p.u[n] = places.u[k];
        p.v[n] = places.v[k];
        p.scale[n] = places.perCell[k] * zStep * share[k];
        p.lane[n] = static_cast<uint8_t>(k);
        ++n;
    }
    p.count = n;
}

void FilteredGradient::at(const Doubles& i, const Doubles& j, const Floats& footprint,
                          Floats2& gradient) const {
    static thread_local Patches patches;
    Ints mip;
    Floats coarser, share, highest;
    chooseMips(footprint, maxMip_, mip, coarser);
    Floats2 sum{};
    Lanes<uint8_t> rest{};
    for (const int pass : {0, 1}) {
        for (int k = 0; k < kBatch; ++k) share[k] = pass ? coarser[k] : 1.0f - coarser[k];
        if (pass)
            for (int k = 0; k < kBatch; ++k) mip[k] = mip[k] < maxMip_ ? mip[k] + 1 : maxMip_;
        fetch(mip, share, i, j, patches, rest);
        if (patches.count == 0) continue;
        if (cut_.format == 0) decode(patches.codes, patches.heights, highest);
        weigh(patches.heights, patches.u, patches.v, patches.scale, patches.gradient);
        for (int n = 0; n < patches.count; ++n) {
            const int k = patches.lane[n];
            sum.x[k] += patches.gradient.x[n];
            sum.y[k] += patches.gradient.y[n];
            if (cut_.format == 0 && highest[n] == 65535.0f) rest[k] = 1;
        }
    }
    for (int k = 0; k < kBatch; ++k) {
        glm::vec2 g{gradient.x[k], gradient.y[k]};
        if (rest[k] || std::isnan(sum.x[k] + sum.y[k]))
            at(i[k], j[k], footprint[k], g);
        else
            g = {sum.x[k], sum.y[k]};
        gradient.x[k] = g.x;
        gradient.y[k] = g.y;
    }
}

}  // namespace terray
