// SPDX-License-Identifier: Apache-2.0
// Filtered gradients: exact on paraboloids, seamless across tiles and mips, sound beside holes.
#include "shade/normals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "kernel/test_cuts.h"
#include "shade/overview.h"
#include "shade/sky.h"

namespace terray {
namespace {

constexpr double kA = 0.004, kB = -0.003, kC = 0.002, kD = 0.7, kE = -0.4;
double paraboloid(double i, double j) {
    return kA * i * i + kB * j * j + kC * i * j + kD * i + kE * j + 500;
}
glm::vec2 paraboloidGradient(double i, double j) {
    return {2 * kA * i + kC * j + kD, 2 * kB * j + kC * i + kE};
}

struct Scene {
    test::Heights heights;
    test::TestCut cut;
    TilingScheme scheme;
    FilteredGradient gradient;
    Scene(test::Heights z, bool int16 = false)
        : heights(std::move(z)),
          cut(heights, {.int16 = int16}),
          scheme{heights.columns, heights.rows},
          gradient(cut.cut(), scheme) {}
};

TEST(FilteredGradient, IsExactOnAParaboloidInEveryTile) {
    const Scene scene({1400, 700, paraboloid});
    std::mt19937 random(1);
    std::uniform_real_distribution<double> x(3, 1390), y(3, 690);
    for (int k = 0; k < 3000; ++k) {
        const double i = k % 3 ? x(random) : 512 + (k % 50) * 0.05 - 1, j = y(random);
        glm::vec2 g;
        ASSERT_TRUE(scene.gradient.ofMip(0, i, j, g));
        const glm::vec2 expected = paraboloidGradient(i, j);
        EXPECT_NEAR(g.x, expected.x, 2e-3f * (1 + std::abs(expected.x))) << i << " " << j;
        EXPECT_NEAR(g.y, expected.y, 2e-3f * (1 + std::abs(expected.y))) << i << " " << j;
    }
}

TEST(FilteredGradient, FollowsALargeFootprintOnCoarserMips) {
    const Scene scene({1400, 700, paraboloid});
    for (float footprint : {0.1f, 1.0f, 3.0f, 8.0f, 20.0f}) {
        glm::vec2 g;
        ASSERT_TRUE(scene.gradient.at(640.3, 350.7, footprint, g));
        const glm::vec2 expected = paraboloidGradient(640.3, 350.7);
        EXPECT_NEAR(g.x, expected.x, 0.02f) << footprint;
        EXPECT_NEAR(g.y, expected.y, 0.02f) << footprint;
    }
}

TEST(FilteredGradient, IsContinuousAcrossCellsTilesAndMips) {
    for (bool int16 : {false, true}) {
        const Scene scene(test::roughTerrain(1100, 300, 400, 9), int16);
        for (float footprint : {0.5f, 5.0f}) {
            glm::vec2 last, now;
            ASSERT_TRUE(scene.gradient.at(505, 120.3, footprint, last));
            for (double i = 505; i < 520; i += 0.01) {
                ASSERT_TRUE(scene.gradient.at(i, 120.3, footprint, now));
                EXPECT_LT(glm::length(now - last), 0.05f * (1 + glm::length(now))) << i;
                last = now;
            }
        }
        glm::vec2 last, now;
        ASSERT_TRUE(scene.gradient.at(400.2, 99.1, 0.4f, last));
        for (float footprint = 0.4f; footprint < 200; footprint *= 1.01f) {
            ASSERT_TRUE(scene.gradient.at(400.2, 99.1, footprint, now));
            EXPECT_LT(glm::length(now - last), 0.08f * (1 + glm::length(last))) << footprint;
            last = now;
        }
    }
}

TEST(FilteredGradient, GoesStraightOnAtTheSheetsEdgeAndBesideHoles) {
    const auto plane = [](int i, int j) { return 3.0 * i - 2.0 * j; };
    test::Heights heights(60, 50, plane);
    heights.at(30, 25) = std::numeric_limits<float>::quiet_NaN();
    const Scene scene(heights);
    for (auto [i, j] :
         {std::pair{0.0, 0.0}, {0.5, 48.9}, {59.0, 49.0}, {28.5, 24.5}, {31.5, 26.5}}) {
        glm::vec2 g;
        ASSERT_TRUE(scene.gradient.at(i, j, 0.5f, g)) << i << " " << j;
        EXPECT_NEAR(g.x, 3, 1e-4f);
        EXPECT_NEAR(g.y, -2, 1e-4f);
    }
    glm::vec2 g;
    EXPECT_FALSE(scene.gradient.ofMip(0, 29.5, 24.5, g));
}

TEST(FilteredGradient, SmallestTerrainWorks) {
    const Scene scene({2, 2, [](int i, int j) { return i + 2.0 * j; }});
    glm::vec2 g;
    ASSERT_TRUE(scene.gradient.at(0.5, 0.5, 100, g));
    EXPECT_NEAR(g.x, 1, 1e-5f);
    EXPECT_NEAR(g.y, 2, 1e-5f);
}

TEST(Overview, HoldsTheMipThatFitsWholeAcrossTiles) {
    const Scene scene({1100, 600, paraboloid});
    const Overview all = makeOverview(scene.cut.cut(), scene.scheme, 1'000'000);
    ASSERT_EQ(all.mip, 0);
    ASSERT_EQ(all.width, 1100);
    for (size_t k = 0; k < all.heights.size(); ++k)
        ASSERT_EQ(all.heights[k], scene.heights.z[k]) << k;
    const Overview small = makeOverview(scene.cut.cut(), scene.scheme, 200'000);
    EXPECT_EQ(small.mip, 1);
    EXPECT_EQ(small.width, 551);
    EXPECT_EQ(small.height, 301);
}

TEST(Overview, MeanSlopeIsAPlanesSlopeOnAnyMip) {
    const Scene scene({700, 600, [](int i, int j) { return 3.0 * i + 4.0 * j; }});
    const Affine2 map{{0, 0}, {10, 0}, {0, -10}};
    for (int64_t posts : {1'000'000, 200'000})
        EXPECT_NEAR(meanSlope(makeOverview(scene.cut.cut(), scene.scheme, posts), map), 0.5, 0.01);
}

TEST(SkyLight, PlainsSeeAllAndExaggerationDeepensHollows) {
    const Affine2 map{{0, 0}, {10, 0}, {0, -10}};
    const Scene plain({200, 100, [](int, int) { return 42.0; }});
    const SkyLight flat(makeOverview(plain.cut.cut(), plain.scheme, 1 << 20), map, 1);
    EXPECT_NEAR(flat.at(100, 50, 0.5f), 1, 1e-3f);
    EXPECT_NEAR(flat.at(199, 99, 300), 1, 1e-3f);
    const Scene valley({200, 100, [](int i, int) { return 5.0 * std::abs(i - 100); }});
    float last = 1;
    for (double exaggeration : {1.0, 2.0, 4.0}) {
        const SkyLight sky(makeOverview(valley.cut.cut(), valley.scheme, 1 << 20), map,
                           exaggeration);
        EXPECT_LT(sky.at(100, 50, 1), last - 0.05f);
        last = sky.at(100, 50, 1);
    }
}

}  // namespace
}  // namespace terray
