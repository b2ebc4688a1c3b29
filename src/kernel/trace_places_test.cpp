// SPDX-License-Identifier: Apache-2.0
// The tracer where it is hard: posts and edges, grazing and far rays, the bowl, the terrain's rim.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "kernel/test_cuts.h"
#include "kernel/test_trace.h"

namespace terray {
namespace {

using oracle::ExactHit;
using test::CutChoice;
using test::expectLikeOracle;
using test::expectShadowsLikeOracle;
using test::forEachTarget;
using test::Heights;
using test::Place;
using test::placeOf;
using test::Random;
using test::randomRays;
using test::TestCut;
using test::towards;
using test::trace;
using test::uniform;

/// Rays with whole and half coordinates in eight directions, and straight down and up.
TEST(Tracer, AxesDiagonalsPostsAndEdges) {
    CutChoice choice;
    choice.mipOfTile = [](int x, int) { return x < 2 ? 0 : 1; };
    TestCut terrain(test::roughTerrain(2049, 65, 40, 9), choice);
    Random random(21);
    std::vector<Ray> rays;
    const auto whole = [&random](int low, int high) {
        return static_cast<double>(low +
                                   static_cast<int>(random() % static_cast<uint64_t>(high - low)));
    };
    while (rays.size() < 4000) {
        const double dx = whole(-1, 2), dy = whole(-1, 2);
        const double x = whole(980, 1070) + 0.5 * whole(0, 2), y = whole(0, 65);
        double dz = uniform(random, -1, 0.3);
        if (dx == 0 && dy == 0 && dz == 0) continue;
        if (rays.size() % 4 == 0) dz = 0;
        if (dx == 0 && dy == 0) dz = rays.size() % 2 == 0 ? -1 : 1;
        rays.push_back({x, y, uniform(random, 0, 45), dx, dy, dz});
        if (rays.size() % 3 == 0) rays.back().x -= 1200 * dx, rays.back().y -= 1200 * dy;
    }
    expectLikeOracle(terrain.cut(), rays);
    terrain.setSurface(kSurfaceTriangles);
    expectLikeOracle(terrain.cut(), rays, 4);  // along diagonals
    terrain.setSurface(kSurfaceConstant);
    for (Ray& ray : rays) ray.x += 0.25, ray.y += 0.25;  // walls and posts coincide otherwise
    expectLikeOracle(terrain.cut(), rays);
}

/// Flat ground with a little relief, seen from far away under a tiny angle.
TEST(Tracer, GrazingRaysOverFlatGround) {
    const double cell = 50;
    for (const double relief : {0.0, 0.02, 2.0}) {
        TestCut terrain(test::roughTerrain(1025, 200, relief, 31));
        Random random(32);
        std::vector<Ray> rays;
        for (int k = 0; k < 3000; ++k) {
            const Place eye{uniform(random, -100, 20), uniform(random, 0, 199),
                            relief + uniform(random, 0.01, 60)};
            const Place target{uniform(random, 900, 1024), uniform(random, 0, 199),
                               uniform(random, -0.1, relief + 0.1)};
            rays.push_back(towards(eye, target, 1 / cell, k % 2 == 0 ? 6.8e-8 : 0));
        }
        expectLikeOracle(terrain.cut(), rays);
    }
}

TEST(Tracer, EyesVeryFarAway) {
    TestCut terrain(test::roughTerrain(600, 600, 300, 41));
    Random random(42);
    std::vector<Ray> rays;
    for (int k = 0; k < 6000; ++k) {
        const double azimuth = uniform(random, 0, 7), far = k % 2 == 0 ? 6.4e6 : 2e5;
        const Place target{uniform(random, 0, 599), uniform(random, 0, 599),
                           uniform(random, 0, 300)};
        const Place eye{target[0] + far * std::cos(azimuth), target[1] + far * std::sin(azimuth),
                        far * uniform(random, 0, 1)};
        rays.push_back(towards(eye, target, 1, k % 3 == 0 ? 1e-9 : 0));
    }
    expectLikeOracle(terrain.cut(), rays);
}

/// A closed bowl with a rough floor: no ray from inside gets out below the rim.
TEST(Tracer, BowlIsWatertight) {
    Heights bowl = test::roughTerrain(601, 601, 20, 51);
    for (int j = 0; j <= 600; ++j)
        for (int i = 0; i <= 600; ++i) {
            const double r = std::hypot(i - 300, j - 300) / 300;
            bowl.at(i, j) += static_cast<float>(400 * r * r);
        }
    TestCut terrain(bowl);
    Random random(52);
    std::vector<Ray> rays;
    for (int k = 0; k < 12000; ++k) {
        double x = uniform(random, 150, 450), y = uniform(random, 150, 450);
        double dx = uniform(random, -1, 1), dy = uniform(random, -1, 1);
        if (k % 3 == 0) x = std::round(x), y = std::round(y);
        if (k % 5 == 0) dx = std::round(dx), dy = std::round(dy);
        rays.push_back({x, y, 300, dx, dy, uniform(random, -1, 0.05 * std::hypot(dx, dy)) - 1e-6});
    }
    for (const SurfaceKind surface : test::kAllSurfaces) {
        terrain.setSurface(surface);
        forEachTarget([&] {
            const std::vector<Hit> hits = trace(terrain.cut(), rays);
            EXPECT_EQ(std::count_if(hits.begin(), hits.end(), isHit),
                      static_cast<long>(rays.size()));
        });
    }
    terrain.setSurface(kSurfaceTriangles);
    expectLikeOracle(terrain.cut(), rays);
    terrain.setSurface(kSurfaceBilinear);
    expectLikeOracle(terrain.cut(), rays);
}

/// On with the same ray behind each hit: through the sheet, from below, and out again.
TEST(Tracer, GoingOnBehindAHit) {
    TestCut terrain(test::roughTerrain(300, 300, 60, 61));
    std::vector<Ray> rays = randomRays(terrain.cut(), 4000, 1, 62);
    for (int round = 0; round < 3; ++round) {
        std::vector<Ray> next;
        const std::vector<ExactHit> exact = expectLikeOracle(terrain.cut(), rays);
        for (size_t k = 0; k < rays.size(); ++k) {
            if (!isHit(exact[k].hit)) continue;
            next.push_back(rays[k]);
            next.back().tMin = exact[k].t + 1e-3;
            next.back().tMax = 1e30;
        }
        EXPECT_GT(next.size(), 100u);
        rays = next;
    }
}

/// Coarse saddles that reach beyond the terrain's rectangle: nothing is hit out there.
TEST(Tracer, TheRectangleEndsAllRays) {
    CutChoice choice;
    choice.mipOfTile = [](int, int) { return 2; };
    const double half = std::acos(-1.0) / 4;
    TestCut terrain(Heights(1026, 70,
                            [half](int i, int j) {
                                return 200 * std::cos(half * i) * std::cos(half * j) +
                                       0.3 * (i * 7 % 11) + 0.2 * (j * 5 % 13);
                            }),
                    choice);
    const TerrainCut& cut = terrain.cut();
    Random random(82);
    std::vector<Ray> rays;
    while (rays.size() < 6000) {
        const Place target{uniform(random, 1020, 1026), uniform(random, 64, 70),
                           uniform(random, -40, 40)};
        const Place eye{target[0] + uniform(random, -9, 9), target[1] + uniform(random, -9, 9),
                        uniform(random, -80, 80)};
        rays.push_back(towards(eye, target));
    }
    for (const SurfaceKind surface : test::kAllSurfaces) {
        terrain.setSurface(surface);
        expectLikeOracle(cut, rays);
        const std::vector<Hit> hits = trace(cut, rays);
        std::vector<Ray> suns(hits.size(), Ray{0, 0, 0, 0, 0, 1});
        for (size_t k = 0; k < hits.size(); ++k) {
            if (!isHit(hits[k])) continue;
            const Place from = placeOf(cut, rays[k], hits[k]);
            suns[k] =
                towards(from, {from[0] + uniform(random, -1, 1), from[1] + uniform(random, -1, 1),
                               from[2] + uniform(random, -9, 9)});
        }
        EXPECT_GT(expectShadowsLikeOracle(cut, hits, suns), 100);
    }
}

TEST(Tracer, NothingToHit) {
    Heights none(600, 40, [](int, int) { return 0; });
    std::fill(none.z.begin(), none.z.end(), std::numeric_limits<float>::quiet_NaN());
    none.at(10, 10) = 5;  // a single post makes no cell
    for (const bool int16 : {false, true}) {
        const TestCut terrain(none,
                              CutChoice{int16, 1, kSurfaceBilinear, [](int, int) { return 0; }});
        const std::vector<Ray> rays{
            {10, 10, 50, 0, 0, -1}, {0, 10, 5, 1, 0, 0}, {-5, -5, 9, 1, 1, -0.1}};
        forEachTarget([&] {
            for (const Hit& hit : trace(terrain.cut(), rays)) EXPECT_FALSE(isHit(hit));
        });
    }
}

bool sameBits(const Hit& a, const Hit& b) {
    if (isHit(a) != isHit(b)) return false;
    return !isHit(a) ||
           (std::bit_cast<uint32_t>(a.t) == std::bit_cast<uint32_t>(b.t) && a.tile == b.tile &&
            a.cell == b.cell && a.u == b.u && a.v == b.v && a.mip == b.mip && a.flags == b.flags);
}

TEST(Tracer, BatchingChangesNothing) {
    TestCut terrain(test::townTerrain(640, 300, 50, 71));
    const std::vector<Ray> rays = randomRays(terrain.cut(), 3000, 1, 72);
    forEachTarget([&] {
        const std::vector<Hit> together = trace(terrain.cut(), rays);
        std::vector<size_t> order(rays.size());
        std::iota(order.begin(), order.end(), size_t{0});
        std::shuffle(order.begin(), order.end(), Random(73));
        std::vector<Ray> shuffled;
        for (const size_t k : order) shuffled.push_back(rays[k]);
        for (const size_t batch : {size_t{1}, size_t{7}, size_t{64}, size_t{1000}})
            for (size_t first = 0; first < rays.size(); first += batch) {
                const auto from = shuffled.begin() + static_cast<std::ptrdiff_t>(first);
                const size_t count = std::min(batch, rays.size() - first);
                const std::vector<Hit> hits =
                    trace(terrain.cut(), {from, from + static_cast<std::ptrdiff_t>(count)});
                for (size_t k = 0; k < count; ++k)
                    ASSERT_TRUE(sameBits(hits[k], together[order[first + k]])) << batch;
            }
    });
}

}  // namespace
}  // namespace terray
