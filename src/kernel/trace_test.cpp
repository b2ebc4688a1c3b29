// SPDX-License-Identifier: Apache-2.0
// The tracer against the oracle: every SIMD target of the machine, both post formats, both
// surfaces.
#include "kernel/trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include "kernel/height.h"
#include "kernel/scalar/judge.h"
#include "kernel/scalar/oracle.h"
#include "kernel/test_cuts.h"

namespace terray {
namespace {

using oracle::ExactHit;
using oracle::Fault;
using test::CutChoice;
using test::Heights;
using test::TestCut;

using Random = std::mt19937_64;
double uniform(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

/// Runs a check once per SIMD target; restores the best one.
template <class Check>
void forEachTarget(const Check& check) {
    for (const std::string& target : simdTargets()) {
        SCOPED_TRACE(target);
        ASSERT_TRUE(setSimdTarget(target));
        EXPECT_EQ(activeSimdTarget(), target);
        check();
    }
    ASSERT_TRUE(setSimdTarget(""));
}

std::vector<Hit> trace(const TerrainCut& cut, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    TraceCounters counters;
    firstHits(cut, rays, hits, counters);
    EXPECT_EQ(counters.rays, rays.size());
    EXPECT_EQ(counters.hits, static_cast<uint64_t>(std::count_if(hits.begin(), hits.end(), isHit)));
    return hits;
}

/// Every ray on every target like the oracle. Returns the oracle's hits. Random rays do not tie.
std::vector<ExactHit> expectLikeOracle(const TerrainCut& cut, const std::vector<Ray>& rays,
                                       int maxTies = 0) {
    std::vector<ExactHit> exact(rays.size());
    std::transform(rays.begin(), rays.end(), exact.begin(),
                   [&cut](const Ray& ray) { return oracle::firstHit(cut, ray); });
    forEachTarget([&] {
        const std::vector<Hit> hits = trace(cut, rays);
        int faults = 0, ties = 0;
        for (size_t k = 0; k < rays.size(); ++k) {
            const Fault fault = oracle::judge(cut, rays[k], hits[k], exact[k]);
            ties += fault == Fault::Tie ? 1 : 0;
            if (oracle::isViolation(fault) && ++faults <= 3)
                ADD_FAILURE() << "ray " << k << ": "
                              << oracle::describe(fault, rays[k], hits[k], exact[k]);
        }
        EXPECT_EQ(faults, 0) << "of " << rays.size();
        EXPECT_LE(ties, maxTies);
    });
    return exact;
}

/// Every shadow ray on every target like the oracle. Returns how many are occluded.
long expectShadowsLikeOracle(const TerrainCut& cut, const std::vector<Hit>& hits,
                             const std::vector<Ray>& suns) {
    std::vector<uint8_t> shadow;
    forEachTarget([&] {
        shadow.assign(hits.size(), 2);
        TraceCounters counters;
        occluded(cut, hits, suns, shadow, counters);
        int faults = 0, ties = 0;
        for (size_t k = 0; k < hits.size(); ++k) {
            const Fault fault = oracle::judgeShadow(cut, hits[k], suns[k], shadow[k] == 1);
            ties += fault == Fault::Tie ? 1 : 0;
            if (oracle::isViolation(fault) && ++faults <= 3)
                ADD_FAILURE() << "ray " << k << ", kernel " << int{shadow[k]} << ", from "
                              << oracle::describe(Fault::None, suns[k], hits[k], {hits[k], 0});
        }
        EXPECT_EQ(faults, 0);
        EXPECT_LE(ties, 1);
        EXPECT_EQ(std::count(shadow.begin(), shadow.end(), 2), 0);
    });
    return std::count(shadow.begin(), shadow.end(), 1);
}

/// `scale`: lattice cells a metre, so that t counts metres.
using Place = std::array<double, 3>;
Ray towards(const Place& from, const Place& to, double scale = 1, double bend = 0) {
    const double x = (to[0] - from[0]) / scale, y = (to[1] - from[1]) / scale, z = to[2] - from[2];
    const double length = std::hypot(x, y, z);
    const double horizontal = (x * x + y * y) / (length * length);
    return {from[0],    from[1],          from[2], x / length * scale, y / length * scale,
            z / length, bend * horizontal};
}

/// Where a hit lies: on the sheet, or at the ray's height on a strip or wall.
Place placeOf(const TerrainCut& cut, const Ray& ray, const Hit& hit) {
    const LatticePlace place = hitPlace(cut, hit);
    const double t = static_cast<double>(hit.t);
    const bool strip = (hit.flags & kHitStrip) != 0;
    return {place.i, place.j, strip ? ray.z + (ray.dz + ray.bend * t) * t : hitHeight(cut, hit)};
}

/// Random rays: eyes inside, beside, above and below the box; targets near the sheet.
std::vector<Ray> randomRays(const TerrainCut& cut, int count, double scale, uint64_t seed) {
    Random random(seed);
    const double low = static_cast<double>(cut.minZ), high = static_cast<double>(cut.maxZ);
    const double range = std::max(high - low, 1e-3);
    const double bends[] = {0, 6.8e-8, 2e-5 / std::max(1.0, cut.cellsX / scale / 1000)};
    std::vector<Ray> rays;
    while (static_cast<int>(rays.size()) < count) {
        const double spread = random() % 4 == 0 ? 0.6 : 0.1;
        const auto place = [&](int cells) { return cells * uniform(random, -spread, 1 + spread); };
        const Place eye{place(cut.cellsX), place(cut.cellsY),
                        low + range * uniform(random, -0.5, 2.5)};
        const Place target{uniform(random, 0, cut.cellsX), uniform(random, 0, cut.cellsY),
                           low + range * uniform(random, -0.1, 1.1)};
        Ray ray = towards(eye, target, scale, bends[random() % 3]);
        if (random() % 8 == 0) ray.tMin = uniform(random, 0, range);
        if (random() % 8 == 0) ray.tMax = ray.tMin + uniform(random, 0, 4 * range);
        rays.push_back(ray);
    }
    return rays;
}

struct Terrain {
    const char* name;
    Heights heights;
    int rays;
    double scale = 1;  // cells a metre
    double zStep = 0;
    bool mixed = false;
};

Terrain makeTerrain(const std::string& name) {
    const auto lifted = [](Heights heights, float by) {
        for (float& z : heights.z) z += by;
        return heights;
    };
    const auto holed = [](Heights heights) {
        test::punchHoles(heights, 400, 8);
        return heights;
    };
    if (name == "rough") return {"rough", test::roughTerrain(700, 300, 90, 1), 6000};
    if (name == "fine cells") return {"", test::roughTerrain(700, 300, 0.7, 2), 6000, 100};
    if (name == "wide cells") return {"", test::roughTerrain(1100, 600, 2500, 3), 6000, 0.1};
    if (name == "town") return {"", test::townTerrain(640, 400, 50, 4), 6000, 1, 0.25};
    if (name == "holes") return {"", holed(test::townTerrain(640, 400, 50, 5)), 6000};
    if (name == "lifted") return {"", lifted(test::roughTerrain(640, 300, 60, 6), 8000), 6000};
    if (name == "sunk") return {"", lifted(test::roughTerrain(300, 640, 60, 7), -11000), 6000};
    if (name == "tiny slopes") return {"", test::roughTerrain(640, 300, 0.01, 8), 6000, 0.1};
    if (name == "huge slopes") return {"", test::roughTerrain(300, 300, 40000, 9), 6000};
    if (name == "mixed mips")
        return {"", test::roughTerrain(1540, 1100, 200, 10), 8000, 0.5, 0, true};
    return {"", holed(test::townTerrain(1540, 1100, 50, 11)), 8000, 1, 0, true};  // mixed town
}

class RandomRays : public ::testing::TestWithParam<const char*> {};

TEST_P(RandomRays, HitLikeTheOracle) {
    const Terrain terrain = makeTerrain(GetParam());
    uint64_t seed = 100;
    for (const bool int16 : {false, true}) {
        CutChoice choice{int16, terrain.zStep, false, [](int, int) { return 0; }};
        if (terrain.mixed)
            choice.mipOfTile = [](int x, int y) { return (x < 2) + (y < 2 && x < 2); };
        TestCut cut(terrain.heights, choice);
        for (const bool constant : {false, true}) {
            SCOPED_TRACE(::testing::Message() << (int16 ? "int16" : "float")
                                              << (constant ? ", constant" : ", bilinear"));
            cut.setConstantSurface(constant);
            const auto rays = randomRays(cut.cut(), terrain.rays / 2, terrain.scale, ++seed);
            const auto exact = expectLikeOracle(cut.cut(), rays);
            const auto hits = std::count_if(exact.begin(), exact.end(),
                                            [](const ExactHit& e) { return isHit(e.hit); });
            EXPECT_GT(hits, static_cast<long>(rays.size() / 4));
        }
    }
}

TEST_P(RandomRays, ShadowsLikeTheOracle) {
    const Terrain terrain = makeTerrain(GetParam());
    CutChoice choice{true, terrain.zStep, false, [](int, int) { return 0; }};
    if (terrain.mixed) choice.mipOfTile = [](int x, int y) { return x % 2 + (y < 2 && x < 2); };
    TestCut owner(terrain.heights, choice);
    const TerrainCut& cut = owner.cut();
    for (const bool constant : {false, true}) {
        SCOPED_TRACE(constant ? "constant" : "bilinear");
        owner.setConstantSurface(constant);
        const auto views = randomRays(cut, terrain.rays / 3, terrain.scale, 200);
        const std::vector<Hit> hits = trace(cut, views);
        Random random(12);
        std::vector<Ray> suns(hits.size());
        for (size_t k = 0; k < hits.size(); ++k) {
            if (!isHit(hits[k])) continue;
            const Place from = placeOf(cut, views[k], hits[k]);
            const double relief = static_cast<double>(cut.maxZ - cut.minZ);
            const Place to{from[0] + cut.cellsX * uniform(random, -1, 1),
                           from[1] + cut.cellsY * uniform(random, -1, 1),
                           from[2] + 3 * relief * uniform(random, -0.2, 1)};
            suns[k] = towards(from, to, terrain.scale, 6.8e-8);
        }
        EXPECT_GT(expectShadowsLikeOracle(cut, hits, suns), 100);
    }
}

INSTANTIATE_TEST_SUITE_P(Tracer, RandomRays,
                         ::testing::Values("rough", "fine cells", "wide cells", "town", "holes",
                                           "lifted", "sunk", "tiny slopes", "huge slopes",
                                           "mixed mips", "mixed town"),
                         [](const auto& instance) {
                             std::string name = instance.param;
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

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
    terrain.setConstantSurface(true);
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
    for (const bool constant : {false, true}) {
        terrain.setConstantSurface(constant);
        forEachTarget([&] {
            const std::vector<Hit> hits = trace(terrain.cut(), rays);
            EXPECT_EQ(std::count_if(hits.begin(), hits.end(), isHit),
                      static_cast<long>(rays.size()));
        });
    }
    terrain.setConstantSurface(false);
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

/// Coarse cells that reach beyond the terrain's rectangle: nothing is hit out there.
TEST(Tracer, TheRectangleEndsAllRays) {
    CutChoice choice;
    choice.mipOfTile = [](int, int) { return 2; };
    TestCut terrain(test::roughTerrain(1026, 70, 300, 81), choice);
    const TerrainCut& cut = terrain.cut();
    Random random(82);
    std::vector<Ray> rays;
    for (int k = 0; k < 4000; ++k) {
        const Place target{uniform(random, 1020, 1030), uniform(random, 60, 72),
                           uniform(random, 0, 300)};
        const Place eye{target[0] + uniform(random, -9, 9), target[1] + uniform(random, -9, 9),
                        150};
        rays.push_back(towards(eye, target));
    }
    for (const bool constant : {false, true}) {
        terrain.setConstantSurface(constant);
        expectLikeOracle(cut, rays);
        const std::vector<Hit> hits = trace(cut, rays);
        std::vector<Ray> suns(hits.size(), Ray{0, 0, 0, 0, 0, 1});
        for (size_t k = 0; k < hits.size(); ++k) {
            if (!isHit(hits[k])) continue;
            const Place from = placeOf(cut, rays[k], hits[k]);
            suns[k] =
                towards(from, {from[0] + uniform(random, -1, 1), from[1] + uniform(random, -1, 1),
                               from[2] + uniform(random, -9, 30)});
        }
        EXPECT_GT(expectShadowsLikeOracle(cut, hits, suns), 20);
    }
}

TEST(Tracer, NothingToHit) {
    Heights none(600, 40, [](int, int) { return 0; });
    std::fill(none.z.begin(), none.z.end(), std::numeric_limits<float>::quiet_NaN());
    none.at(10, 10) = 5;  // a single post makes no cell
    for (const bool int16 : {false, true}) {
        const TestCut terrain(none, CutChoice{int16, 1, false, [](int, int) { return 0; }});
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
