// SPDX-License-Identifier: Apache-2.0
// The tracer against the oracle on random rays: every SIMD target of the machine, both post
// formats, all surfaces, first hits and shadows.
#include "kernel/trace.h"
#include "base/test_size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernel/test_cuts.h"
#include "kernel/test_trace.h"

namespace terray {
namespace {

using oracle::ExactHit;
using test::CutChoice;
using test::expectLikeOracle;
using test::expectShadowsLikeOracle;
using test::Heights;
using test::Place;
using test::placeOf;
using test::Random;
using test::randomRays;
using test::TestCut;
using test::towards;
using test::trace;
using test::uniform;

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
    if (name == "high plain")
        return {"", lifted(test::roughTerrain(640, 300, 0.2f, 12), 8000), 6000};
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
        CutChoice choice{int16, terrain.zStep, kSurfaceBilinear, [](int, int) { return 0; }};
        if (terrain.mixed)
            choice.mipOfTile = [](int x, int y) { return (x < 2) + (y < 2 && x < 2); };
        TestCut cut(terrain.heights, choice);
        for (const SurfaceKind surface : test::kAllSurfaces) {
            SCOPED_TRACE(::testing::Message()
                         << (int16 ? "int16" : "float") << ", surface " << surface);
            cut.setSurface(surface);
            const auto rays =
                randomRays(cut.cut(), terrain.rays / 2 / test::kLess, terrain.scale, ++seed);
            const auto exact = expectLikeOracle(cut.cut(), rays);
            const auto hits = std::count_if(exact.begin(), exact.end(),
                                            [](const ExactHit& e) { return isHit(e.hit); });
            EXPECT_GT(hits, static_cast<long>(rays.size() / 4));
        }
    }
}

TEST_P(RandomRays, ShadowsLikeTheOracle) {
    const Terrain terrain = makeTerrain(GetParam());
    CutChoice choice{true, terrain.zStep, kSurfaceBilinear, [](int, int) { return 0; }};
    if (terrain.mixed) choice.mipOfTile = [](int x, int y) { return x % 2 + (y < 2 && x < 2); };
    TestCut owner(terrain.heights, choice);
    const TerrainCut& cut = owner.cut();
    for (const SurfaceKind surface : test::kAllSurfaces) {
        SCOPED_TRACE(::testing::Message() << "surface " << surface);
        owner.setSurface(surface);
        const auto views = randomRays(cut, terrain.rays / 3 / test::kLess, terrain.scale, 200);
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
                                           "lifted", "sunk", "high plain", "tiny slopes",
                                           "huge slopes", "mixed mips", "mixed town"),
                         [](const auto& instance) {
                             std::string name = instance.param;
                             std::replace(name.begin(), name.end(), ' ', '_');
                             return name;
                         });

}  // namespace
}  // namespace terray
