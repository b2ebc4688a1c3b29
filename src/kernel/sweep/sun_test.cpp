// SPDX-License-Identifier: Apache-2.0
// Shadows by the sun sweep: the same answer as casting each ray, and as the oracle's, on every SIMD
// target; and the sweep's bounds against brute force.
#include "kernel/sweep/sun.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernel/height.h"
#include "kernel/scalar/judge.h"
#include "kernel/sweep/sun_cache.h"
#include "kernel/test_cuts.h"
#include "kernel/test_trace.h"

namespace terray {
namespace {

using test::CutChoice;
using test::Heights;
using test::Place;
using test::placeOf;
using test::Random;
using test::randomRays;
using test::TestCut;
using test::trace;
using test::uniform;

/// A sun over a lattice of `scale` cells a metre; `skew` turns the lattice against the slopes'
/// growth along the curved earth, as on rotated and sheared lattices.
SunDirection sunAt(double azimuthDeg, double elevationDeg, double scale, double bend,
                   double skew = 0) {
    const double az = azimuthDeg * M_PI / 180, el = elevationDeg * M_PI / 180;
    SunDirection sun;
    sun.dx = std::sin(az) * std::cos(el) * scale;
    sun.dy = -std::cos(az) * std::cos(el) * scale;
    for (double* d : {&sun.dx, &sun.dy})
        if (std::fabs(*d) < 1e-12) *d = 0;
    sun.rise = std::sin(el);
    sun.bend = bend * std::cos(el) * std::cos(el);
    const double squared = sun.dx * sun.dx + sun.dy * sun.dy;
    sun.riseI = 2 * sun.bend * (sun.dx - skew * sun.dy) / squared;
    sun.riseJ = 2 * sun.bend * (sun.dy + skew * sun.dx) / squared;
    return sun;
}

struct Scene {
    std::string name;
    Heights heights;
    double scale = 1;
    bool int16 = true;
    int mixed = 0;  ///< pattern of mips
    int rays = 3000;
    double served = 0.85;  ///< share of the rays that need no casting, at least
};

Scene makeScene(const std::string& name) {
    const auto holed = [](Heights heights) {
        test::punchHoles(heights, 300, 8);
        return heights;
    };
    if (name == "fractal") return {name, test::roughTerrain(1100, 900, 900, 3), 0.1};
    if (name == "float") return {name, test::roughTerrain(600, 1030, 90, 4), 1, false};
    if (name == "town") return {name, test::townTerrain(640, 400, 50, 4), 1};
    if (name == "holes")
        return {name, holed(test::townTerrain(640, 400, 50, 5)), 1, false, 0, 3000, 0};
    if (name == "mixed") return {name, test::roughTerrain(1540, 1100, 200, 10), 0.5, true, 1};
    if (name == "mixed town")
        return {name, holed(test::townTerrain(2100, 1100, 50, 11)), 1, true, 2, 3000, 0};
    if (name == "two posts") return {name, test::roughTerrain(2, 2, 3, 12), 1, true, 0, 300, 0};
    if (name == "strip") return {name, test::roughTerrain(3, 700, 30, 13), 1, false, 0, 1500, 0};
    if (name == "flat") return {name, Heights(600, 300, [](int, int) { return 7.0; }), 1};
    if (name == "lifted") return {name, test::roughTerrain(300, 600, 60, 6), 1, true, 0, 3000, 0.5};
    return {name, test::roughTerrain(700, 300, 0.7, 2), 100};  // fine cells
}

CutChoice choiceOf(const Scene& scene) {
    CutChoice choice{scene.int16, 0, kSurfaceBilinear, [](int, int) { return 0; }};
    if (scene.mixed == 1)
        choice.mipOfTile = [](int x, int y) { return (x < 2) + (y < 2 && x < 2); };
    if (scene.mixed == 2) choice.mipOfTile = [](int x, int y) { return x >= 2 ? 1 + (y > 5) : 0; };
    return choice;
}

class SunSweepScenes : public ::testing::TestWithParam<const char*> {};

/// Hits of random views (also from below and on strips), their rays to the sun, and the same as
/// batches.
struct Asked {
    std::vector<Hit> hits;
    std::vector<Ray> rays;
    std::vector<SunAsks> asks;
};
Asked ask(const TerrainCut& cut, const SunDirection& sun, const std::vector<Ray>& views,
          const std::vector<Hit>& seen) {
    Asked asked;
    asked.hits = seen;
    asked.rays.resize(seen.size(), Ray{0, 0, 0, 0, 0, 1});
    asked.asks.resize((seen.size() + kSunAsks - 1) / kSunAsks);
    for (SunAsks& batch : asked.asks) batch.clear();
    for (size_t k = 0; k < seen.size(); ++k) {
        if (!isHit(seen[k])) continue;
        const auto height = static_cast<float>(placeOf(cut, views[k], seen[k])[2]);
        asked.rays[k] = sunRay(cut, sun, seen[k], height);
        asked.asks[k / kSunAsks].ask(static_cast<int>(k % kSunAsks), seen[k], height);
    }
    return asked;
}

void expectLikeCasting(const TerrainCut& cut, const SunDirection& sun, const Asked& asked,
                       double served, uint64_t& darkRays) {
    const auto sweep = SunSweep::make(cut, sun);
    ASSERT_TRUE(sweep);
    EXPECT_TRUE(sweep->fits(cut, sun));
    std::vector<uint8_t> cast(asked.hits.size(), 2);
    TraceCounters traced;
    occluded(cut, asked.hits, asked.rays, cast, traced);
    test::forEachTarget([&] {
        std::vector<uint8_t> dark(asked.asks.size() * kSunAsks, 2);
        ShadowCounters counters;
        shadows(cut, *sweep, asked.hits, asked.asks, dark, counters);
        EXPECT_EQ(counters.rays, traced.rays);
        EXPECT_EQ(counters.dark, traced.hits);
        darkRays += counters.dark;
        int faults = 0;
        for (size_t k = 0; k < cast.size(); ++k)
            if (dark[k] != cast[k] && ++faults <= 3)
                ADD_FAILURE() << "ray " << k << ", sweep " << int{dark[k]} << ", from "
                              << oracle::describe(oracle::Fault::None, asked.rays[k], asked.hits[k],
                                                  {asked.hits[k], 0});
        EXPECT_EQ(faults, 0) << "of " << cast.size();
        const auto rays = static_cast<double>(
            std::count_if(asked.hits.begin(), asked.hits.end(),
                          [](const Hit& hit) { return hit.flags == kHitValid; }));
        const double above =
            static_cast<double>(counters.cast) - (static_cast<double>(counters.rays) - rays);
        EXPECT_LE(above, rays * (1 - served)) << "cast of " << rays;
    });
    for (size_t k = 0; k < cast.size(); k += 7) {
        const auto fault = oracle::judgeShadow(cut, asked.hits[k], asked.rays[k], cast[k] == 1);
        EXPECT_FALSE(oracle::isViolation(fault)) << k;
    }
}

TEST_P(SunSweepScenes, ShadowsLikeCasting) {
    const Scene scene = makeScene(GetParam());
    const TestCut owner(scene.heights, choiceOf(scene));
    const TerrainCut& cut = owner.cut();
    Random random(77);
    const auto views = randomRays(cut, scene.rays, scene.scale, 300);
    const std::vector<Hit> seen = trace(cut, views);
    std::vector<SunDirection> suns;
    for (int turn = 0; turn < 8; ++turn)  // axes and diagonals
        suns.push_back(sunAt(45.0 * turn, 12 + 9.0 * turn, scene.scale, turn % 2 ? 6.8e-8 : 0));
    for (int k = 0; k < 8; ++k)
        suns.push_back(sunAt(uniform(random, 0, 360),
                             k < 4 ? uniform(random, 1, 12) : uniform(random, 5, 85), scene.scale,
                             k % 2 ? 6.8e-8 : 0, uniform(random, -0.4, 0.4)));
    // As bent as if the earth were the size of the terrain, twenty times over.
    const double metres = std::max(cut.cellsX, cut.cellsY) / scene.scale;
    suns.push_back(sunAt(200, 20, scene.scale, 0.05 / metres, 0.3));
    uint64_t dark = 0;
    for (const SunDirection& sun : suns) {
        SCOPED_TRACE(::testing::Message()
                     << "sun " << sun.dx << ", " << sun.dy << ", " << sun.rise);
        expectLikeCasting(cut, sun, ask(cut, sun, views, seen), scene.served, dark);
    }
    EXPECT_GT(dark, scene.name == "flat" ? 0u : 10u);
}

/// Height above which a ray from a place on a row meets nothing further on, sampled densely.
double shadowHeight(const TerrainCut& cut, const SunDirection& sun, double i, double j) {
    const double step = 1 / std::max(std::fabs(sun.dx), std::fabs(sun.dy));
    const double slope = sun.slopeAt(i, j);
    double best = -std::numeric_limits<double>::infinity();
    for (int k = 0;; ++k) {
        const double t = step * std::max(k / 8.0, 1e-7);  // just behind the row
        const double x = i + sun.dx * t, y = j + sun.dy * t;
        if (x < 0 || y < 0 || x > cut.cellsX || y > cut.cellsY) break;
        const SurfaceCell cell = surfaceCellAt(cut, x, y);
        if (cell.slot != kNoSlot)
            best = std::max(best, cell.height(kSurfaceBilinear) - t * (slope + sun.bend * t));
        if (t * slope > static_cast<double>(cut.maxZ - cut.minZ)) break;
    }
    return best;
}

/// Where a place of a tile, in the sun's axes, lies on the lattice.
std::pair<double, double> latticePlace(const TerrainCut& cut, const SunAxes& axes, uint32_t slot,
                                       double row, double column) {
    const TileDesc& tile = cut.tiles[slot];
    const double size = std::ldexp(1.0, static_cast<int>(tile.mipFlags & kTileMipMask));
    double x = axes.transposed ? row : column, y = axes.transposed ? column : row;
    if (axes.mirroredX) x = 512 - x;
    if (axes.mirroredY) y = 512 - y;
    return {tile.x + x * size, tile.y + y * size};
}

/// From a place `ahead` rows behind the last kept row on, who is above the ground and the bound
/// meets nothing.
void expectFree(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, int row, double column,
                double ahead, double error) {
    const SunDirection& sun = sweep.sun();
    const double before = column - sweep.axes().shear * kSweepStep;
    if (before < 0) return;
    const auto at = [&](double rows) {
        return latticePlace(cut, sweep.axes(), slot, row - kSweepStep + rows,
                            before + sweep.axes().shear * rows);
    };
    const auto [i0, j0] = at(0);
    const auto [i, j] = at(ahead);
    if (i < 0 || j < 0 || i > cut.cellsX || j > cut.cellsY) return;
    const SurfaceCell cell = surfaceCellAt(cut, i, j);
    const double truth = shadowHeight(cut, sun, i, j);
    if (cell.slot == kNoSlot || std::isinf(truth)) return;
    const double t = std::hypot(i - i0, j - j0) / std::hypot(sun.dx, sun.dy);
    const double free =
        sweep.boundsAt(slot, row, column).free + t * (sun.slopeAt(i0, j0) + sun.bend * t);
    EXPECT_GE(std::max(free, cell.height(kSurfaceBilinear)), truth - error) << i << ", " << j;
}

TEST_P(SunSweepScenes, BoundsBracketTheShadowHeight) {
    const Scene scene = makeScene(GetParam());
    const TestCut owner(scene.heights, choiceOf(scene));
    const TerrainCut& cut = owner.cut();
    Random random(78);
    const double range = static_cast<double>(cut.maxZ - cut.minZ), error = 1e-5 * range + 1e-3;
    for (int k = 0; k < 12; ++k) {
        const double azimuth = k < 4 ? 90.0 * k : uniform(random, 0, 360);
        const SunDirection sun = sunAt(azimuth, uniform(random, 2, 60), scene.scale,
                                       k % 2 ? 1e-3 / cut.cellsX * scene.scale : 0, 0.2);
        const auto sweep = SunSweep::make(cut, sun);
        ASSERT_TRUE(sweep);
        const SunAxes& axes = sweep->axes();
        int known = 0;
        for (int n = 0; n < 400; ++n) {
            const auto slots = drawnSlots(cut);
            const uint32_t slot = slots[random() % slots.size()];
            const int row = kSweepStep * (1 + static_cast<int>(random() % kSweepRows));
            const double column = uniform(random, 0, 512);
            const auto [i, j] = latticePlace(cut, axes, slot, row, column);
            if (i < 0 || j < 0 || i > cut.cellsX || j > cut.cellsY) continue;
            const double truth = shadowHeight(cut, sun, i, j);
            if (std::isinf(truth)) continue;
            const auto bounds = sweep->boundsAt(slot, row, column);
            EXPECT_LE(bounds.caught, truth + error) << i << ", " << j;
            expectFree(cut, *sweep, slot, row, column, uniform(random, 0, kSweepStep), error);
            known += bounds.free - bounds.caught < 0.5 * range + error ? 1 : 0;
        }
        EXPECT_GT(known, scene.served > 0.8 ? 20 : -1);
    }
}

INSTANTIATE_TEST_SUITE_P(Kernel, SunSweepScenes,
                         ::testing::Values("fractal", "float", "town", "holes", "mixed",
                                           "mixed town", "two posts", "strip", "flat", "lifted",
                                           "fine cells"),
                         [](const auto& instance) {
                             std::string name = instance.param;
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

TEST(SunSweep, DoesNotDependOnThreads) {
    const TestCut owner(test::roughTerrain(1540, 1100, 200, 16));
    const TerrainCut& cut = owner.cut();
    const SunDirection sun = sunAt(250, 9, 1, 6.8e-8);
    std::shared_ptr<const SunSweep> one, many;
    oneapi::tbb::task_arena(1).execute([&] { one = SunSweep::make(cut, sun); });
    oneapi::tbb::task_arena(8).execute([&] { many = SunSweep::make(cut, sun); });
    size_t compared = 0;
    for (const uint32_t slot : drawnSlots(cut))
        for (int row = kSweepStep; row <= kSlotCells; row += kSweepStep)
            for (const double column : {0.5, 77.3, 300.0, 511.0}) {
                // There are no bounds where there is no terrain.
                const auto [i, j] = latticePlace(cut, one->axes(), slot, row, column);
                if (i < 0 || j < 0 || i > cut.cellsX || j > cut.cellsY) continue;
                ++compared;
                const auto a = one->boundsAt(slot, row, column);
                const auto b = many->boundsAt(slot, row, column);
                ASSERT_TRUE(a.free == b.free && a.caught == b.caught) << slot << ", " << row;
            }
    EXPECT_GT(compared, 5000u);
}

TEST(SunSweep, CacheMakesASweepOnceAndDropsTheOldest) {
    const TestCut owner(test::roughTerrain(300, 300, 60, 17));
    const TestCut other(test::roughTerrain(300, 300, 60, 18));
    SunSweepCache cache(2 * SunSweep::bytesFor(1));
    const SunDirection a = sunAt(30, 20, 1, 0), b = sunAt(31, 20, 1, 0);
    const auto first = cache.get(owner.cut(), a);
    ASSERT_TRUE(first);
    EXPECT_EQ(cache.get(owner.cut(), a), first);
    const auto elsewhere = cache.get(other.cut(), a);
    EXPECT_NE(elsewhere, first);
    EXPECT_TRUE(elsewhere->fits(other.cut(), a));
    EXPECT_FALSE(elsewhere->fits(owner.cut(), a));
    EXPECT_EQ(cache.get(owner.cut(), a), first);  // used after the other one
    cache.get(owner.cut(), b);
    EXPECT_EQ(cache.get(owner.cut(), a), first);
    EXPECT_NE(cache.get(other.cut(), a), elsewhere);
    EXPECT_FALSE(cache.get(owner.cut(), sunAt(30, 90, 1, 0)));
    SunSweepCache tight(1);  // too small for any
    const auto only = tight.get(owner.cut(), a);
    EXPECT_EQ(tight.get(owner.cut(), a), only);
    EXPECT_NE(tight.get(owner.cut(), b), only);
    EXPECT_NE(tight.get(owner.cut(), a), only);
}

TEST(SunSweep, LeavesToCastingWhatItCannotServe) {
    TestCut owner(test::roughTerrain(300, 300, 60, 14));
    const TerrainCut& cut = owner.cut();
    EXPECT_FALSE(SunSweep::make(cut, sunAt(30, 90, 1, 0)));        // overhead
    EXPECT_FALSE(SunSweep::make(cut, sunAt(30, 0.001, 1, 1e-6)));  // sets within the terrain
    const SunDirection sun = sunAt(30, 20, 1, 0);
    const auto sweep = SunSweep::make(cut, sun);
    ASSERT_TRUE(sweep);
    EXPECT_FALSE(sweep->fits(cut, sunAt(31, 20, 1, 0)));
    for (const SurfaceKind unswept : {kSurfaceConstant, kSurfaceTriangles}) {
        owner.setSurface(unswept);
        EXPECT_FALSE(SunSweep::make(cut, sun));
    }
}

}  // namespace
}  // namespace terray
