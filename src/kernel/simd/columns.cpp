// SPDX-License-Identifier: Apache-2.0
// Compiles columns-inl.h for every SIMD target and dispatches; looks up tiles for its lanes.
#include "kernel/simd/columns.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernel/simd/columns.cpp"
#include "hwy/foreach_target.h"
// after foreach_target.h
#include "kernel/simd/columns-inl.h"

#if HWY_ONCE
#include "base/assert.h"
#include "kernel/height.h"

namespace terray {
namespace simd {

HWY_EXPORT(marchRowLanes);

void anchorPosts(const TerrainCut& cut, float anchor, MarchLanes& m, int k) {
    if (cut.format != 0) return;
    const TileDesc& tile = cut.tiles[m.slot[k]];
    const auto anchorZ = static_cast<double>(anchor);
    const double z0 = static_cast<double>(tile.z0), step = static_cast<double>(tile.zStep);
    const double code = step > 0 ? std::clamp(std::round((anchorZ - z0) / step), -1e6, 1e6) : 0.0;
    m.postsCode[k] = static_cast<int32_t>(code);
    m.postsZ[k] = static_cast<float>(z0 + step * code - anchorZ);
    m.postsStep[k] = tile.zStep;
}

void enterMarchTiles(const TerrainCut& cut, float anchorZ, const int32_t* x, const int32_t* y,
                     const int32_t* which, int count, MarchLanes& m, int p) {
    for (int lane = 0; lane < count; ++lane) {
        if (which[lane] == 0) continue;
        const int k = p + lane;
        const uint32_t slot = drawnSlotAt(cut, x[lane], y[lane]);
        m.slot[k] = static_cast<int32_t>(slot);
        if (slot == kNoSlot) {
            m.tileX[k] = m.tileY[k] = -1;
            m.mip[k] = 0;
            continue;
        }
        const TileDesc& tile = cut.tiles[slot];
        m.tileX[k] = tile.x;
        m.tileY[k] = tile.y;
        m.mip[k] = static_cast<int32_t>(tile.mipFlags & kTileMipMask);
        const auto bytes = static_cast<uint32_t>(tile.posts) << (cut.format == 0 ? 1 : 2);
        m.postsOffset[k] = static_cast<int32_t>(bytes ^ 0x80000000u);
        anchorPosts(cut, anchorZ, m, k);
    }
}

namespace {
MarchCounts dispatchRow(const TerrainCut& cut, const MarchGroup* groups, const MarchRow& row,
                        int begin, int end, MarchLanes& lanes, Hit* hits) {
    return HWY_DYNAMIC_DISPATCH(marchRowLanes)(cut, groups, row, begin, end, lanes, hits);
}
}  // namespace

}  // namespace simd

void resetLanes(MarchLanes& m) {
    std::fill_n(m.forward, kMarchColumns, -1.0f);
    std::fill_n(m.limit, kMarchColumns, 1e30f);
    std::fill_n(m.sure, kMarchColumns, -1.0f);
    std::fill_n(m.past, kMarchColumns, 0);
    std::fill_n(m.steps, kMarchColumns, 0);
    std::fill_n(m.calm, kMarchColumns, uint8_t{kNotCalm});
    std::fill_n(m.disturbed, kMarchGroups, false);
    std::fill_n(m.slot, kMarchColumns, static_cast<int32_t>(kNoSlot));
    std::fill_n(m.tileX, kMarchColumns, -1);
    std::fill_n(m.tileY, kMarchColumns, -1);
    std::fill_n(m.mip, kMarchColumns, 0);
    std::fill_n(m.postsOffset, kMarchColumns, INT32_MIN);
    std::fill_n(m.postsCode, kMarchColumns, 0);
    std::fill_n(m.postsZ, kMarchColumns, 0.0f);
    std::fill_n(m.postsStep, kMarchColumns, 0.0f);
    std::fill_n(m.clear, kMarchColumns, 0.0f);
}

void anchorLanes(const TerrainCut& cut, const MarchGroup* groups, MarchLanes& m) {
    for (int k = 0; k < kMarchColumns; ++k) {
        m.calm[k] = std::min(m.calm[k], uint8_t{kCalm});
        if (static_cast<uint32_t>(m.slot[k]) == kNoSlot) continue;
        if (k % kMarchGroupColumns == 0 || m.slot[k] != m.slot[k - 1]) {
            simd::anchorPosts(cut, groups[k / kMarchGroupColumns].anchorZ, m, k);
            continue;
        }
        m.postsCode[k] = m.postsCode[k - 1];
        m.postsZ[k] = m.postsZ[k - 1];
        m.postsStep[k] = m.postsStep[k - 1];
    }
}

MarchCounts marchRow(const TerrainCut& cut, const MarchGroup* groups, const MarchRow& row,
                     int begin, int end, MarchLanes& lanes, Hit* hits) {
    TERRAY_ASSERT(begin >= 0 && end <= kMarchColumns && cut.surface != kSurfaceConstant);
    return simd::dispatchRow(cut, groups, row, begin, end, lanes, hits);
}

}  // namespace terray
#endif  // HWY_ONCE
