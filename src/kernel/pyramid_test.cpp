// SPDX-License-Identifier: Apache-2.0
// Tests of the tile pyramid: strict bounds, holes, tiles that reach beyond the extent.
#include "kernel/pyramid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace terray {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Tile of random posts around a base height, some of them holes.
struct RandomTile {
    std::vector<float> posts = std::vector<float>(kSlotPosts, 0.0f);
    std::vector<uint16_t> codes = std::vector<uint16_t>(kSlotPosts, 0);
    std::vector<uint32_t> bounds = std::vector<uint32_t>(kSlotBounds, 7u);
    TileDesc tile{};

    RandomTile(uint32_t seed, float base, float range, double holeShare) {
        std::mt19937 random(seed);
        std::uniform_real_distribution<float> height(base - range / 2, base + range / 2);
        std::uniform_int_distribution<int> code(0, 65534);
        std::bernoulli_distribution hole(holeShare);
        for (size_t k = 0; k < posts.size(); ++k) {
            const bool isHole = hole(random);
            posts[k] = isHole ? kNaN : height(random);
            codes[k] = isHole ? uint16_t{0xFFFF} : static_cast<uint16_t>(code(random));
        }
        tile.z0 = base;
        tile.zStep = range / 65534.0f;
    }
    double decoded(bool asFloat, int x, int y) const {
        const auto k = static_cast<size_t>(y * kPostStride + x);
        if (asFloat) return static_cast<double>(posts[k]);
        if (codes[k] == 0xFFFF) return static_cast<double>(kNaN);
        return static_cast<double>(std::fma(tile.zStep, static_cast<float>(codes[k]), tile.z0));
    }
    SlotBounds build(bool asFloat, int cellsX, int cellsY) {
        return asFloat ? buildPyramid(posts.data(), cellsX, cellsY, tile, bounds.data())
                       : buildPyramid(codes.data(), cellsX, cellsY, tile, bounds.data());
    }
    double maxOf(uint32_t entry) const {
        return static_cast<double>(
            std::fma(tile.boundsStep, static_cast<float>(entry >> 16), tile.boundsZ0));
    }
    double minOf(uint32_t entry) const {
        return static_cast<double>(
            std::fma(tile.boundsStep, static_cast<float>(entry & 0xFFFFu), tile.boundsZ0));
    }
};

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -low, delta = 0;
    bool hasHoles = false;
    void add(const RandomTile& tile, bool asFloat, int x, int y) {
        const double z[] = {tile.decoded(asFloat, x, y), tile.decoded(asFloat, x + 1, y),
                            tile.decoded(asFloat, x, y + 1), tile.decoded(asFloat, x + 1, y + 1)};
        for (const double corner : z) {
            if (std::isnan(corner)) {
                hasHoles = true;
                return;
            }
        }
        const auto [cellLow, cellHigh] = std::minmax_element(std::begin(z), std::end(z));
        low = std::min(low, *cellLow);
        high = std::max(high, *cellHigh);
        delta = std::max(delta, *cellHigh - *cellLow);
    }
};

Range rangeOf(const RandomTile& tile, bool asFloat, int x0, int y0, int x1, int y1) {
    Range range;
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) range.add(tile, asFloat, x, y);
    }
    return range;
}

/// Every entry of every level against its own cells; `slack` = how loose a bound may be.
void expectStrictBounds(RandomTile& tile, bool asFloat, int cellsX, int cellsY) {
    const SlotBounds whole = tile.build(asFloat, cellsX, cellsY);
    const Range all = rangeOf(tile, asFloat, 0, 0, cellsX, cellsY);
    EXPECT_EQ(static_cast<double>(whole.minZ), all.low);
    EXPECT_EQ(static_cast<double>(whole.maxZ), all.high);
    EXPECT_EQ(whole.hasHoles, all.hasHoles);
    EXPECT_GE(static_cast<double>(whole.maxDelta), all.delta);
    EXPECT_LE(static_cast<double>(whole.maxDelta), all.delta * 1.0001 + 1e-3);
    EXPECT_EQ(whole.maxDelta, tile.tile.maxDelta);
    const double slack = 1.001 * static_cast<double>(tile.tile.boundsStep) * (asFloat ? 1 : 0);
    for (int level = 1; level <= kTileLevels; ++level) {
        const int size = 512 >> level, cells = 1 << level;
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                const uint32_t entry =
                    tile.bounds[levelOffset(level) + static_cast<uint32_t>(y * size + x)];
                const Range range =
                    rangeOf(tile, asFloat, x * cells, y * cells, std::min((x + 1) * cells, cellsX),
                            std::min((y + 1) * cells, cellsY));
                if (range.low > range.high) {
                    ASSERT_EQ(entry, kEmptyBounds) << level << ' ' << x << ' ' << y;
                    continue;
                }
                ASSERT_GE(tile.maxOf(entry), range.high) << level << ' ' << x << ' ' << y;
                ASSERT_LE(tile.minOf(entry), range.low) << level << ' ' << x << ' ' << y;
                ASSERT_LE(tile.maxOf(entry), range.high + slack);
                ASSERT_GE(tile.minOf(entry), range.low - slack);
            }
        }
    }
}

TEST(Pyramid, BoundsAreStrictAndTightWithoutHoles) {
    for (const bool asFloat : {false, true}) {
        RandomTile tile(1, 1500, 3000, 0);
        expectStrictBounds(tile, asFloat, 512, 512);
    }
}

TEST(Pyramid, HolesDoNotCount) {
    for (const bool asFloat : {false, true}) {
        RandomTile sparse(2, -300, 500, 0.02);
        expectStrictBounds(sparse, asFloat, 512, 512);
        RandomTile dense(3, 100, 50, 0.7);
        expectStrictBounds(dense, asFloat, 512, 512);
    }
}

TEST(Pyramid, CellsBeyondTheExtentAreEmpty) {
    uint32_t seed = 10;
    for (const auto& [cellsX, cellsY] : {std::pair{1, 1}, {1, 512}, {511, 3}, {77, 130}}) {
        for (const bool asFloat : {false, true}) {
            RandomTile tile(seed++, 0, 1000, 0.01);
            tile.posts[0] = tile.posts[1] = tile.posts[kPostStride] = tile.posts[kPostStride + 1] =
                5.0f;
            tile.codes[0] = tile.codes[1] = tile.codes[kPostStride] = tile.codes[kPostStride + 1] =
                9;
            expectStrictBounds(tile, asFloat, cellsX, cellsY);
        }
    }
}

TEST(Pyramid, FlatGroundHighUpIsBoundedWithinFloatPrecision) {
    RandomTile rough(20, 8848, 0.25f, 0);
    expectStrictBounds(rough, true, 512, 512);
    RandomTile huge(21, 1e7f, 3, 0);
    expectStrictBounds(huge, true, 512, 512);
    RandomTile flat(22, 4321, 0, 0);
    expectStrictBounds(flat, true, 512, 512);
    EXPECT_EQ(flat.tile.maxDelta, 0.0f);
}

TEST(Pyramid, FloatBoundsNeedNoRounding) {
    // boundsZ0 + boundsStep * code is exact, however a kernel computes it.
    RandomTile tile(30, 1234.567f, 2800, 0);
    tile.build(true, 512, 512);
    const TileDesc& t = tile.tile;
    for (uint32_t code = 0; code < 65535; code += 13) {
        const float fused = std::fma(t.boundsStep, static_cast<float>(code), t.boundsZ0);
        const double exact =
            static_cast<double>(t.boundsStep) * code + static_cast<double>(t.boundsZ0);
        ASSERT_EQ(static_cast<double>(fused), exact);
    }
}

TEST(Pyramid, AllHoleTileIsEmpty) {
    for (const bool asFloat : {false, true}) {
        RandomTile tile(40, 0, 10, 1.0);
        const SlotBounds whole = tile.build(asFloat, 512, 512);
        EXPECT_GT(whole.minZ, whole.maxZ);
        EXPECT_TRUE(whole.hasHoles);
        EXPECT_EQ(whole.maxDelta, 0.0f);
        for (const uint32_t entry : tile.bounds) ASSERT_EQ(entry, kEmptyBounds);
    }
}

}  // namespace
}  // namespace terray
