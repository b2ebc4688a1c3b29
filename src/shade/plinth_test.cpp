// SPDX-License-Identifier: Apache-2.0
// The rim is the outer border of the ground in straight sides, and the plinth a closed block.
#include "shade/plinth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "shade/rim.h"
#include "shade/test_terrain.h"

namespace terray {
namespace {

using test::FunctionSource;
using test::ShadeScene;

constexpr double kHole = std::numeric_limits<double>::quiet_NaN();

Overview overviewOf(int size, const std::function<bool(int, int)>& isGround) {
    Overview view{0, size, size, {}};
    for (int j = 0; j < size; ++j)
        for (int i = 0; i < size; ++i)
            view.heights.push_back(isGround(i, j) ? 1.0f : std::numeric_limits<float>::quiet_NaN());
    return view;
}

double areaOf(const RimLoop& loop) {
    double twice = 0;
    for (size_t k = 0; k < loop.size(); ++k) {
        const Vec2 &a = loop[k], &b = loop[(k + 1) % loop.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return 0.5 * twice;
}

TEST(Rim, OfAFullRasterIsItsBorder) {
    const auto loops = outerRims(overviewOf(20, [](int, int) { return true; }));
    ASSERT_EQ(loops.size(), 1u);
    const RimLoop expected{{0, 0}, {19, 0}, {19, 19}, {0, 19}};
    EXPECT_EQ(loops[0], expected);
}

TEST(Rim, DoesNotGoAroundHolesInside) {
    const auto loops =
        outerRims(overviewOf(40, [](int i, int j) { return std::hypot(i - 20, j - 20) > 6; }));
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_EQ(loops[0].size(), 4u);
}

TEST(Rim, OfASlightlyTurnedSheetHasFourStraightSidesInsideIt) {
    const auto depth = [](double i, double j) {  // from the nearest side of the turned square
        constexpr double kTurn = 0.02, kHalf = 130;
        const double x = (i - 150) * std::cos(kTurn) + (j - 150) * std::sin(kTurn);
        const double y = (j - 150) * std::cos(kTurn) - (i - 150) * std::sin(kTurn);
        return kHalf - std::max(std::abs(x), std::abs(y));
    };
    const auto loops = outerRims(overviewOf(300, [&](int i, int j) { return depth(i, j) >= 0; }));
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_LE(loops[0].size(), 8u);
    for (const Vec2& corner : loops[0]) {
        EXPECT_GE(depth(corner.x, corner.y), 0);
        EXPECT_LE(depth(corner.x, corner.y), 4);
    }
    EXPECT_GT(areaOf(loops[0]), 250.0 * 250.0);
}

TEST(Rim, SeparateSheetsHaveSeparateRims) {
    const auto loops = outerRims(overviewOf(60, [](int i, int) { return i < 20 || i > 40; }));
    ASSERT_EQ(loops.size(), 2u);
    for (const RimLoop& loop : loops) EXPECT_GE(areaOf(loop), 16.0 * 57.0);
}

TEST(Rim, TakesNarrowVoidsAtTheBorderForGroundAndWideOnesForOutside) {
    const auto loops = outerRims(overviewOf(400, [](int i, int j) {
        const bool narrow = std::abs(i - 100) < 3 && j < 200,
                   wide = std::abs(i - 300) < 9 && j < 200;
        return !narrow && !wide;
    }));
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_NEAR(areaOf(loops[0]), 399.0 * 399.0 - 200.0 * 18.0, 3000);
    for (const Vec2& corner : loops[0]) EXPECT_GT(std::abs(corner.x - 100), 20);
}

/// A disc of ground with a hole in it.
struct DiscScene {
    static double height(int64_t i, int64_t j) {
        const double r = std::hypot(static_cast<double>(i - 60), static_cast<double>(j - 60));
        return r > 55 || r < 8 ? kHole : 100 + static_cast<double>((i * 7 + j * 3) % 5);
    }
    FunctionSource source{121, 121, 10, height};
    ShadeScene scene{source, cameraOver(source, 8, 8)};
    Plinth plinth{scene.cut.cut(), source.info(), scene.rays,
                  outerRims(makeOverview(scene.cut.cut(), source.info().scheme, 1 << 20))};
};

TEST(Plinth, CarriesTheGroundWithinTheRimAndTheHolesInIt) {
    const DiscScene disc;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> place(-10, 130);
    for (int k = 0; k < 2000; ++k) {
        const double i = place(random), j = place(random), r = std::hypot(i - 60, j - 60);
        if (r < 50) {
            EXPECT_TRUE(disc.plinth.isUnder(i, j)) << i << ' ' << j;
        }
        if (r > 56) {
            EXPECT_FALSE(disc.plinth.isUnder(i, j)) << i << ' ' << j;
        }
    }
}

TEST(Plinth, LevelRaysFromOutsideMeetAFaceThatLooksAtThem) {
    const DiscScene disc;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> turn(0, 2 * kPi);
    for (int k = 0; k < 500; ++k) {
        const double a = turn(random), b = a + 0.3 * std::sin(turn(random));
        Ray ray{60 + 200 * std::cos(a), 60 + 200 * std::sin(a), 90};
        ray.dx = -0.1 * std::cos(b);
        ray.dy = -0.1 * std::sin(b);
        const double closest = 200 * std::abs(std::sin(b - a));
        const auto seen = disc.plinth.firstSeen(ray, ray.tMax);
        if (closest > 56) {
            EXPECT_FALSE(seen.has_value());
        }
        if (closest > 50) continue;
        ASSERT_TRUE(seen.has_value());
        EXPECT_FALSE(seen->inHole);
        const double i = ray.x + ray.dx * static_cast<double>(seen->t);
        const double j = ray.y + ray.dy * static_cast<double>(seen->t);
        EXPECT_NEAR(std::hypot(i - 60, j - 60), 53, 3.5);
        EXPECT_LT(static_cast<double>(seen->outwards.x) * ray.dx -
                      static_cast<double>(seen->outwards.y) * ray.dy,
                  0);  // the lattice's j points to -y
        ray.z = 120;   // over everything
        EXPECT_FALSE(disc.plinth.firstSeen(ray, ray.tMax).has_value());
    }
}

TEST(Plinth, AHoleShowsRockAndTheUndersideIsClosed) {
    const DiscScene disc;
    Ray down{60, 60, 500, 0, 0, -1};
    const auto rock = disc.plinth.firstSeen(down, down.tMax);
    ASSERT_TRUE(rock.has_value());
    EXPECT_TRUE(rock->inHole);
    Ray up{70, 70, -1000, 0, 0, 1};
    const auto bottom = disc.plinth.firstSeen(up, up.tMax);
    ASSERT_TRUE(bottom.has_value());
    EXPECT_FALSE(bottom->inHole);
    EXPECT_LT(bottom->outwards.z, 0);
    Ray beside{118, 118, 500, 0, 0, -1};
    EXPECT_FALSE(disc.plinth.firstSeen(beside, beside.tMax).has_value());
}

}  // namespace
}  // namespace terray
