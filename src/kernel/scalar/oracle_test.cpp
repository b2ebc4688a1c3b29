// SPDX-License-Identifier: Apache-2.0
// The oracle against formulas, dense sampling and the letter of docs/surface.md.
#include "kernel/scalar/oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kernel/test_cuts.h"

namespace terray {
namespace {

using oracle::ExactHit;
using oracle::firstHit;
using test::CutChoice;
using test::Heights;
using test::TestCut;

const double kNan = std::numeric_limits<double>::quiet_NaN();

double uniform(std::mt19937_64& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

Ray towards(double x, double y, double z, double toX, double toY, double toZ) {
    Ray ray{x, y, z, toX - x, toY - y, toZ - z};
    const double length = std::hypot(ray.dx, ray.dy, ray.dz);
    ray.dx /= length;
    ray.dy /= length;
    ray.dz /= length;
    return ray;
}

double heightOfRay(const Ray& ray, double t) { return ray.z + ray.dz * t + ray.bend * t * t; }

/// Height of the bilinear surface, written apart from the oracle.
double sampleSurface(const Heights& h, double x, double y) {
    const int i = std::min(static_cast<int>(x), h.columns - 2);
    const int j = std::min(static_cast<int>(y), h.rows - 2);
    const double u = x - i, v = y - j;
    return (1 - u) * (1 - v) * static_cast<double>(h.at(i, j)) +
           u * (1 - v) * static_cast<double>(h.at(i + 1, j)) +
           (1 - u) * v * static_cast<double>(h.at(i, j + 1)) +
           u * v * static_cast<double>(h.at(i + 1, j + 1));
}

/// The same of the two triangles.
double sampleTriangles(const Heights& h, double x, double y) {
    const int i = std::min(static_cast<int>(x), h.columns - 2);
    const int j = std::min(static_cast<int>(y), h.rows - 2);
    const double u = x - i, v = y - j;
    const double a = static_cast<double>(h.at(i + 1, j)), b = static_cast<double>(h.at(i, j + 1));
    if (u + v <= 1) return (1 - u - v) * static_cast<double>(h.at(i, j)) + u * a + v * b;
    return (u + v - 1) * static_cast<double>(h.at(i + 1, j + 1)) + (1 - v) * a + (1 - u) * b;
}

TEST(Oracle, PlaneIsHitWhereTheFormulaSays) {
    const TestCut terrain(Heights(33, 21, [](int i, int j) { return 3 + 0.5 * i - 0.25 * j; }));
    std::mt19937_64 random(1);
    for (int k = 0; k < 2000; ++k) {
        const double x = uniform(random, 0, 32), y = uniform(random, 0, 20);
        const double sx = uniform(random, -50, 80), sy = uniform(random, -50, 80);
        const double sz = 3 + 0.5 * sx - 0.25 * sy + uniform(random, 1, 90);
        const Ray ray = towards(sx, sy, sz, x, y, 3 + 0.5 * x - 0.25 * y);
        const ExactHit hit = firstHit(terrain.cut(), ray);
        ASSERT_TRUE(isHit(hit.hit));
        EXPECT_NEAR(hit.t, std::hypot(sx - x, sy - y, sz - (3 + 0.5 * x - 0.25 * y)), 1e-9);
        EXPECT_EQ(hit.hit.flags, kHitValid);
        EXPECT_NEAR(cellX(hit.hit) + static_cast<double>(hit.hit.u), x, 1e-6);
        EXPECT_NEAR(cellY(hit.hit) + static_cast<double>(hit.hit.v), y, 1e-6);
    }
}

TEST(Oracle, RoughSurfacesAgreeWithDenseSampling) {
    const Heights paraboloid(17, 17, [](int i, int j) { return 0.2 * i * i + 0.1 * j * j; });
    const Heights rough = test::roughTerrain(17, 17, 20, 5);
    std::mt19937_64 random(2);
    for (const Heights* heights : {&paraboloid, &rough}) {
        const TestCut terrain(*heights);
        for (int k = 0; k < 150; ++k) {
            Ray ray =
                towards(uniform(random, 0, 16), uniform(random, 0, 16), uniform(random, -5, 60),
                        uniform(random, 0, 16), uniform(random, 0, 16), uniform(random, -5, 60));
            ray.bend = k % 3 == 0 ? 0.02 * (ray.dx * ray.dx + ray.dy * ray.dy) : 0;
            const double step = 1e-3;
            double sampled = std::numeric_limits<double>::infinity();
            const auto f = [&](double t) {
                return heightOfRay(ray, t) -
                       sampleSurface(*heights, ray.x + ray.dx * t, ray.y + ray.dy * t);
            };
            const double first = f(0);
            for (double t = step;; t += step) {
                const double x = ray.x + ray.dx * t, y = ray.y + ray.dy * t;
                if (x < 0 || y < 0 || x > 16 || y > 16 || t > 200) break;
                if (f(t) * first > 0) continue;
                sampled = t;
                break;
            }
            const ExactHit hit = firstHit(terrain.cut(), ray);
            if (isHit(hit.hit)) {
                EXPECT_NEAR(f(hit.t), 0, 1e-9);
                EXPECT_EQ((hit.hit.flags & kHitFromBelow) != 0, first < 0);
                EXPECT_LT(hit.t, sampled);  // earlier than a step only where it touches and leaves
                if (hit.t < sampled - 1.5 * step) {
                    EXPECT_NEAR(f(hit.t + step), 0, 0.01);
                }
            } else {
                EXPECT_TRUE(std::isinf(sampled));
            }
        }
    }
}

TEST(Oracle, SpikeBlocksOnlyBelowItsFlanks) {
    const TestCut terrain(
        Heights(5, 5, [](int i, int j) { return i == 2 && j == 2 ? 10.0 : 0.0; }));
    ExactHit hit = firstHit(terrain.cut(), Ray{-3, 2, 5, 1, 0, 0});
    ASSERT_TRUE(isHit(hit.hit));
    EXPECT_DOUBLE_EQ(hit.t, 4.5);
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{-3, 2, 10.001, 1, 0, 0}).hit));
    EXPECT_DOUBLE_EQ(firstHit(terrain.cut(), Ray{-3, 2, 10, 1, 0, 0}).t, 5.0);
    hit = firstHit(terrain.cut(), Ray{-3, 2.5, 2.5, 1, 0, 0});  // half the height at v = 0.5
    EXPECT_DOUBLE_EQ(hit.t, 4.5);
}

TEST(Oracle, SaddleHasTwoRootsOneOrNone) {
    const TestCut terrain(Heights(2, 2, [](int i, int j) { return i == j ? 0.0 : 1.0; }));
    for (const double z : {0.4, 0.499, 0.5}) {  // along the diagonal: 2 s (1 - s)
        const ExactHit hit = firstHit(terrain.cut(), Ray{-1, -1, z, 1, 1, 0});
        ASSERT_TRUE(isHit(hit.hit)) << z;
        EXPECT_NEAR(hit.t, 1 + 0.5 * (1 - std::sqrt(1 - 2 * z)), 1e-12);
        EXPECT_EQ(hit.hit.flags, kHitValid);
    }
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{-1, -1, 0.5 + 1e-12, 1, 1, 0}).hit));
    // Along the other diagonal it sags to 0.5 in the middle: seen from below.
    EXPECT_NEAR(firstHit(terrain.cut(), Ray{0, 1, 0.6, 1, -1, 0}).t, 0.5 - std::sqrt(0.05), 1e-12);
    EXPECT_EQ(firstHit(terrain.cut(), Ray{0, 1, 0.6, 1, -1, 0}).hit.flags,
              kHitValid | kHitFromBelow);
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{0, 1, 0.49, 1, -1, 0}).hit));
}

TEST(Oracle, BentRaysFollowTheParabola) {
    const TestCut terrain(Heights(601, 5, [](int, int) { return 2; }));
    Ray ray{0.25, 2.3, 102, 1, 0, -0.5, 0.0005};
    const double root = (0.5 - std::sqrt(0.25 - 4 * 0.0005 * 100)) / (2 * 0.0005);
    EXPECT_NEAR(firstHit(terrain.cut(), ray).t, root, 1e-9);
    ray.tMin = root + 1;  // starts below, comes up again
    const ExactHit hit = firstHit(terrain.cut(), ray);
    EXPECT_FALSE(isHit(hit.hit));  // beyond the end of the terrain at 600
    ray.dz = -0.3, ray.z = 2 + 0.3 * 0.3 / (4 * 0.0005) - 1e-6;  // barely touches at t = 300
    EXPECT_NEAR(firstHit(terrain.cut(), ray).t, 300 - std::sqrt(1e-6 / 0.0005), 1e-6);
    ray.z += 2e-6;
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), ray).hit));
}

TEST(Oracle, StripBetweenUnlikeMipsIsASurface) {
    // Fine: 0 and 10 in turn; coarse: the mean, 5.
    CutChoice choice;
    choice.mipOfTile = [](int x, int) { return x < 2 ? 0 : 1; };
    const TestCut terrain(Heights(2049, 41, [](int, int j) { return j % 2 * 10; }), choice);
    ExactHit hit = firstHit(terrain.cut(), Ray{1000, 20, 2.5, 1, 0, 0});
    ASSERT_TRUE(isHit(hit.hit));
    EXPECT_DOUBLE_EQ(hit.t, 24);
    EXPECT_EQ(hit.hit.flags, kHitValid | kHitStrip);
    EXPECT_EQ(hit.hit.mip, 1);
    EXPECT_EQ(hit.hit.tile, terrain.slotOf(1, 1, 0));
    EXPECT_EQ(hit.hit.cell, 10u * 512);
    EXPECT_FLOAT_EQ(hit.hit.u, 0);
    hit = firstHit(terrain.cut(), Ray{1100, 20, 2.5, -1, 0, 0});
    EXPECT_DOUBLE_EQ(hit.t, 76);
    EXPECT_EQ(hit.hit.flags, kHitValid | kHitStrip | kHitFromBelow);
    EXPECT_EQ(hit.hit.mip, 0);
    EXPECT_FLOAT_EQ(hit.hit.u, 1);
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{1000, 20, 5.1, 1, 0, 0}).hit));
}

TEST(Oracle, TrianglesMeetOnTheDiagonal) {
    CutChoice choice;
    choice.surface = kSurfaceTriangles;
    // Posts 0 but for 8 at (1, 1): level below the diagonal, 8 (u + v - 1) above it.
    const TestCut corner(Heights(2, 2, [](int i, int j) { return i == 1 && j == 1 ? 8.0 : 0.0; }),
                         choice);
    std::mt19937_64 random(7);
    for (int k = 0; k < 500; ++k) {
        const double x = uniform(random, 0, 1), y = uniform(random, 0, 1);
        const double z = 8 * std::max(x + y - 1, 0.0);
        EXPECT_NEAR(firstHit(corner.cut(), Ray{x, y, 20, 0, 0, -1}).t, 20 - z, 1e-9);
    }
    EXPECT_NEAR(firstHit(corner.cut(), Ray{-1, -1, 4, 1, 1, 0}).t, 1.75, 1e-12);
    EXPECT_EQ(firstHit(corner.cut(), Ray{2, 2, 4, -1, -1, 0}).hit.flags, kHitValid | kHitFromBelow);
    // A ridge along the diagonal, a valley along the diagonal.
    const TestCut ridge(Heights(2, 2, [](int i, int j) { return i != j ? 6.0 : 0.0; }), choice);
    EXPECT_NEAR(firstHit(ridge.cut(), Ray{0, 0, 5, 1, 1, 0}).t, 5.0 / 12, 1e-12);
    EXPECT_TRUE(isHit(firstHit(ridge.cut(), Ray{0, 0, 6 - 1e-9, 1, 1, 0}).hit));
    EXPECT_FALSE(isHit(firstHit(ridge.cut(), Ray{0, 0, 6 + 1e-9, 1, 1, 0}).hit));
    const TestCut valley(Heights(2, 2, [](int i, int j) { return i == j ? 6.0 : 0.0; }), choice);
    EXPECT_NEAR(firstHit(valley.cut(), Ray{0, 0, 9, 1, 1, -8}).t, 0.75, 1e-12);
    EXPECT_NEAR(firstHit(valley.cut(), Ray{0.5, 0.5, 9, 0, 0, -1}).t, 9, 1e-12);
    const Ray bent{0, 0, 6.5, 1, 1, -14, 14};  // below the rim, above the valley
    EXPECT_FALSE(isHit(firstHit(valley.cut(), bent).hit));
}

TEST(Oracle, TrianglesAgreeWithDenseSampling) {
    const Heights rough = test::roughTerrain(17, 17, 20, 5);
    CutChoice choice;
    choice.surface = kSurfaceTriangles;
    const TestCut terrain(rough, choice);
    std::mt19937_64 random(3);
    for (int k = 0; k < 100; ++k) {
        Ray ray = towards(uniform(random, 0, 16), uniform(random, 0, 16), uniform(random, 5, 60),
                          uniform(random, 0, 16), uniform(random, 0, 16), uniform(random, -5, 15));
        ray.bend = k % 3 == 0 ? 0.02 * (ray.dx * ray.dx + ray.dy * ray.dy) : 0;
        const auto f = [&](double t) {
            return heightOfRay(ray, t) -
                   sampleTriangles(rough, ray.x + ray.dx * t, ray.y + ray.dy * t);
        };
        const ExactHit hit = firstHit(terrain.cut(), ray);
        const double end = isHit(hit.hit) ? hit.t - 1e-6 : 200;
        for (double t = 0; t < end; t += 1e-3) {  // nothing before
            const double x = ray.x + ray.dx * t, y = ray.y + ray.dy * t;
            if (x < 0 || y < 0 || x > 16 || y > 16) break;
            ASSERT_GT(f(t) * f(0), 0) << k;
        }
        if (isHit(hit.hit)) {
            EXPECT_NEAR(f(hit.t), 0, 1e-9);
        }
    }
}

TEST(Oracle, ConstantSurfaceHasLevelQuadrantsAndWalls) {
    CutChoice choice;
    choice.surface = kSurfaceConstant;
    const TestCut terrain(Heights(3, 3, [](int i, int) { return i * 10; }), choice);
    ExactHit hit = firstHit(terrain.cut(), Ray{-1, 0.7, 5, 1, 0, 0});
    EXPECT_DOUBLE_EQ(hit.t, 1.5);
    EXPECT_EQ(hit.hit.flags, kHitValid | kHitStrip);
    EXPECT_EQ(hit.hit.cell, 0u);
    EXPECT_FLOAT_EQ(hit.hit.u, 0.5f);
    hit = firstHit(terrain.cut(), Ray{1, 0.7, 5, -1, 0, 0});
    EXPECT_DOUBLE_EQ(hit.t, 0.5);
    EXPECT_EQ(hit.hit.flags, kHitValid | kHitStrip | kHitFromBelow);
    EXPECT_LT(hit.hit.u, 0.5f);
    for (const double x : {0.1, 0.49, 0.51, 1.2, 1.49, 1.6}) {
        const ExactHit down = firstHit(terrain.cut(), Ray{x, 1.3, 100, 0, 0, -1});
        EXPECT_DOUBLE_EQ(down.t, 100 - 10 * std::round(x));
        EXPECT_EQ(down.hit.flags, kHitValid);
    }
}

TEST(Oracle, HolesHaveNoWallsAndCarryNoSign) {
    Heights heights(9, 9, [](int i, int) { return i < 4 ? 0 : 10; });
    heights.at(4, 4) = static_cast<float>(kNan);
    const TestCut terrain(heights);
    for (const double y : {3.5, 4.0, 4.5}) {  // above 0, through the hole, on below 10
        EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{0, y, 5, 1, 0, 0}).hit)) << y;
        EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{8, y, 5, -1, 0, 0}).hit)) << y;
    }
    EXPECT_TRUE(isHit(firstHit(terrain.cut(), Ray{0, 2.5, 5, 1, 0, 0}).hit));
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{4.5, 4.5, 50, 0, 0, -1}).hit));
    EXPECT_TRUE(isHit(firstHit(terrain.cut(), Ray{2.5, 4.5, 50, 0, 0, -1}).hit));
}

TEST(Oracle, VerticalRaysHitEverywhere) {
    const Heights heights = test::roughTerrain(9, 9, 100, 3);
    const TestCut terrain(heights);
    for (double y = 0; y <= 8; y += 0.25)
        for (double x = 0; x <= 8; x += 0.25) {
            const double z = sampleSurface(heights, x, y);
            EXPECT_NEAR(firstHit(terrain.cut(), Ray{x, y, 300, 0, 0, -2}).t, (300 - z) / 2, 1e-9);
            const ExactHit up = firstHit(terrain.cut(), Ray{x, y, -50, 0, 0, 1});
            EXPECT_NEAR(up.t, z + 50, 1e-9);
            EXPECT_EQ(up.hit.flags, kHitValid | kHitFromBelow);
            EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{x, y, 300, 0, 0, 1}).hit));
        }
    EXPECT_FALSE(isHit(firstHit(terrain.cut(), Ray{8.001, 1, 300, 0, 0, -1}).hit));
}

TEST(Oracle, NothingSlipsThroughPostsEdgesAndStrips) {
    CutChoice choice;
    choice.mipOfTile = [](int x, int) { return x < 2 ? 0 : 1; };
    const TestCut terrain(test::roughTerrain(2049, 65, 40, 9), choice);
    std::mt19937_64 random(4);
    const auto snap = [&random](double value) {  // posts and edges, mostly
        return random() % 4 != 0 ? std::round(value) : value;
    };
    for (int k = 0; k < 4000; ++k) {
        const double x = snap(uniform(random, 990, 1060)), y = snap(uniform(random, 0, 64));
        const double dx = snap(uniform(random, -3, 3)), dy = snap(uniform(random, -3, 3));
        const double sx = std::clamp(x - 4 * dx, 0.0, 2048.0),
                     sy = std::clamp(y - 4 * dy, 0.0, 64.0);
        const Ray ray{sx, sy, 60, x - sx, y - sy, -80};  // from above all to below all
        const ExactHit hit = firstHit(terrain.cut(), ray);
        ASSERT_TRUE(isHit(hit.hit)) << k;
        EXPECT_GT(hit.t, 0);
        EXPECT_LT(hit.t, 1);
        EXPECT_EQ(hit.hit.flags & kHitFromBelow, 0);
    }
}

TEST(Oracle, PassingClearedBlocksChangesNoHit) {
    Heights heights = test::townTerrain(1400, 700, 15, 11);
    test::punchHoles(heights, 40, 12);
    CutChoice choice;
    choice.mipOfTile = [](int x, int y) { return x == 0 ? 0 : 1 + y; };
    TestCut terrain(heights, choice);
    const TerrainCut& cut = terrain.cut();
    const oracle::BlockRanges ranges(cut);
    std::mt19937_64 random(13);
    int hits = 0;
    uint64_t steps = 0, fewerSteps = 0;
    for (int k = 0; k < 4500; ++k) {
        terrain.setSurface(test::kAllSurfaces[k % 3]);
        Ray ray = towards(uniform(random, -40, 1440), uniform(random, -40, 740),
                          uniform(random, -20, 120), uniform(random, 0, 1399),
                          uniform(random, 0, 699), uniform(random, -10, 60));
        if (k % 4 == 0) ray.x = std::round(ray.x), ray.dx = 0;
        if (k % 5 == 0) ray.dz = 0.01;
        if (k % 2 == 0) ray.bend = 1e-4 * (ray.dx * ray.dx + ray.dy * ray.dy);
        const ExactHit hit = firstHit(cut, ray), sooner = firstHit(cut, ray, &ranges);
        ASSERT_EQ(isHit(hit.hit), isHit(sooner.hit)) << k;
        if (!isHit(hit.hit)) continue;
        ++hits;
        EXPECT_EQ(hit.t, sooner.t);
        EXPECT_EQ(hit.hit.tile, sooner.hit.tile);
        EXPECT_EQ(hit.hit.cell, sooner.hit.cell);
        EXPECT_EQ(hit.hit.flags, sooner.hit.flags);
        EXPECT_EQ(hit.hit.u, sooner.hit.u);
        EXPECT_EQ(hit.hit.v, sooner.hit.v);
        steps += hit.hit.steps;
        fewerSteps += sooner.hit.steps;
        const Ray sun{ray.x + ray.dx * hit.t, ray.y + ray.dy * hit.t, heightOfRay(ray, hit.t),
                      uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -0.1, 1)};
        EXPECT_EQ(oracle::occluded(cut, hit.hit, sun),
                  oracle::occluded(cut, hit.hit, sun, &ranges));
    }
    EXPECT_GT(hits, 1500);
    EXPECT_LT(2 * fewerSteps, steps);
}

TEST(Oracle, StartsOnBelowAndFarFromTheSheet) {
    const TestCut flat(Heights(17, 17, [](int, int) { return 7; }));
    for (const double x : {0.0, 3.0, 4.3, 15.5}) {
        Ray ray{x, 2.5, 9, 0.1, 0.3, -1, 0, 2};
        EXPECT_EQ(firstHit(flat.cut(), ray).t, 2);
        EXPECT_FALSE(isHit(firstHit(flat.cut(), Ray{x, 2.5, 6, 0.1, 0.3, -1}).hit));
        EXPECT_TRUE(isHit(firstHit(flat.cut(), Ray{x, 2.5, 6, 0, 0, 1}).hit));
        ray.tMax = 1.9, ray.tMin = 0;
        EXPECT_FALSE(isHit(firstHit(flat.cut(), ray).hit));
        const double far = 6.4e6;
        const Ray fromSpace = towards(x - 0.3 * far, 2.5 - 0.4 * far, 7 + far, x + 0.1, 2.5, 7);
        EXPECT_NEAR(firstHit(flat.cut(), fromSpace).t, std::hypot(0.3 * far + 0.1, 0.4 * far, far),
                    1e-6);
    }
}

/// A ray from a place on the sheet.
bool shadowed(const TestCut& terrain, const Ray& view, double dx, double dy, double dz) {
    const ExactHit hit = firstHit(terrain.cut(), view);
    EXPECT_TRUE(isHit(hit.hit));
    const Ray sun{
        view.x + view.dx * hit.t, view.y + view.dy * hit.t, heightOfRay(view, hit.t), dx, dy, dz};
    return oracle::occluded(terrain.cut(), hit.hit, sun);
}

TEST(OracleShadow, PlaneNeverShadowsItself) {
    const TestCut terrain(Heights(33, 33, [](int i, int j) { return 3 + 0.7 * i - 0.3 * j; }));
    std::mt19937_64 random(6);
    for (int k = 0; k < 3000; ++k) {
        double x = uniform(random, 0, 32), y = uniform(random, 0, 32);
        if (k % 3 != 0) x = std::round(x);
        if (k % 3 == 2) y = std::round(y);
        const double dx = k % 5 == 0 ? 0 : uniform(random, -1, 1);
        const double dy = k % 7 == 0 ? 0 : uniform(random, -1, 1);
        const double up = 0.7 * dx - 0.3 * dy;
        const Ray view{x, y, 200, 0, 0, -1};
        EXPECT_FALSE(shadowed(terrain, view, dx, dy, up + 1e-4)) << k;
        EXPECT_TRUE(shadowed(terrain, view, dx, dy, up - 1e-4)) << k;
        EXPECT_FALSE(shadowed(terrain, Ray{x, y, -200, 0, 0, 1}, dx, dy, up - 1e-4)) << k;
    }
}

TEST(OracleShadow, SecondRootInTheCellAndLaterCellsBlock) {
    const TestCut saddle(Heights(2, 2, [](int i, int j) { return i == j ? 0.0 : 1.0; }));
    const Ray view{0.1, 0.1, 5, 0, 0, -1};  // along the diagonal: 2 s (1 - s), slope 1.6 at 0.1
    EXPECT_FALSE(shadowed(saddle, view, 1, 1, 1.61));
    EXPECT_TRUE(shadowed(saddle, view, 1, 1, 1.59));
    const Ray across{0.1, 0.9, 5, 0, 0, -1};  // the sagging diagonal: falls, then rises to 1
    EXPECT_TRUE(shadowed(saddle, across, 1, -1, 0));
    EXPECT_FALSE(shadowed(saddle, across, 1, -1, 0.3));
    const TestCut ridge(Heights(9, 9, [](int i, int) { return i == 6 ? 10 : 0; }));
    EXPECT_TRUE(shadowed(ridge, Ray{2.5, 3, 9, 0, 0, -1}, 1, 0, 2.8));
    EXPECT_FALSE(shadowed(ridge, Ray{2.5, 3, 9, 0, 0, -1}, 1, 0, 2.9));
}

TEST(OracleShadow, TheOtherTriangleOfTheCellBlocks) {
    CutChoice choice;
    choice.surface = kSurfaceTriangles;
    const TestCut corner(Heights(2, 2, [](int i, int j) { return i == 1 && j == 1 ? 8.0 : 0.0; }),
                         choice);
    const Ray level{0.25, 0.25, 9, 0, 0, -1}, slope{0.75, 0.75, 9, 0, 0, -1};
    EXPECT_FALSE(shadowed(corner, level, 1, 1, 10.7));  // over (1, 1) at 0.75 * 10.7 = 8.03
    EXPECT_TRUE(shadowed(corner, level, 1, 1, 10.6));
    EXPECT_TRUE(shadowed(corner, level, 1, 1, -0.1));
    EXPECT_FALSE(shadowed(corner, slope, -1, -1, -5.3));  // leaves at t = 0.75, above 0
    EXPECT_TRUE(shadowed(corner, slope, -1, -1, -5.4));
    EXPECT_TRUE(shadowed(corner, slope, -1, -1, -15.9));
    EXPECT_TRUE(shadowed(corner, slope, -1, -1, -16.1));
    EXPECT_TRUE(shadowed(corner, slope, 1, 1, 15.9));
}

TEST(OracleShadow, WallsShadeTheirFootNotTheirFace) {
    CutChoice choice;
    choice.surface = kSurfaceConstant;
    const TestCut steps(Heights(9, 9, [](int i, int) { return i < 4 ? 0 : 10; }), choice);
    const Ray foot{3.2, 4.2, 50, 0, 0, -1}, face{0, 4.2, 5, 1, 0, 0}, roof{3.6, 4.2, 50, 0, 0, -1};
    EXPECT_TRUE(shadowed(steps, foot, 1, 0, 1));
    EXPECT_FALSE(shadowed(steps, foot, -1, 0, 1));
    EXPECT_FALSE(shadowed(steps, face, -1, 0.2, 1));
    EXPECT_TRUE(shadowed(steps, face, 1, 0.2, 1));
    EXPECT_FALSE(shadowed(steps, roof, 1, 0.3, 0.1));
    EXPECT_FALSE(shadowed(steps, roof, -1, 0.3, 0.1));
}

}  // namespace
}  // namespace terray
