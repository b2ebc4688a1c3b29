// SPDX-License-Identifier: Apache-2.0
// The shader text as C++: how much it leaves open, and that it always ends. That its hits are the
// oracle's is tested with every other kernel's (kernel/test_trace.h).
#include <gtest/gtest.h>

#include <cmath>

#include "base/test_size.h"
#include "kernel/glsl/test_program.h"
#include "kernel/scalar/judge.h"
#include "kernel/test_cuts.h"
#include "kernel/test_trace.h"

namespace terray {
namespace {

using test::CutChoice;
using test::Place;
using test::Random;
using test::ShaderShares;
using test::TestCut;
using test::towards;
using test::traceByShader;
using test::uniform;

/// Rays of a perspective picture.
std::vector<Ray> pictureRays(const Place& eye, double azimuth, double pitch, double scale) {
    std::vector<Ray> rays;
    const double ca = std::cos(azimuth), sa = std::sin(azimuth);
    const double cp = std::cos(pitch), sp = std::sin(pitch);
    for (int j = 0; j < 72; j += test::kLess)
        for (int i = 0; i < 128; ++i) {
            const double right = (i - 63.5) / 110, up = (35.5 - j) / 110;
            const double ahead = cp - up * sp;
            const double x = ahead * ca - right * sa, y = ahead * sa + right * ca;
            rays.push_back(towards(eye,
                                   {eye[0] + x * scale, eye[1] + y * scale, eye[2] + sp + up * cp},
                                   scale, 6.8e-8));
        }
    return rays;
}

TEST(ShaderText, LeavesLittleOpenInPictures) {
    for (const bool int16 : {false, true}) {
        CutChoice choice;
        choice.int16 = int16;
        TestCut terrain(test::roughTerrain(1025, 1025, 300, 3), choice);
        for (const auto& shader : test::shaderTraces())
            for (const SurfaceKind surface : test::kAllSurfaces) {
                SCOPED_TRACE(shader.name);
                terrain.setSurface(surface);
                ShaderShares shares;
                for (const double height : {320.0, 3000.0})
                    for (const double pitch : {-0.05, -1.5})
                        traceByShader(terrain.cut(),
                                      pictureRays({130, 120, height}, 0.7, pitch, 0.1),
                                      shader.trace, shares);
                EXPECT_GT(shares.share(shares.certainHits), 0.6);
                EXPECT_GT(shares.share(shares.certainMisses), 0.1);
                EXPECT_LT(shares.share(shares.uncertain), 0.004);
                EXPECT_LT(shares.share(shares.placesOpen), 0.004);
            }
    }
}

/// Rays that a device has made itself, and knows less well.
TEST(ShaderText, HoldsForRaysThatAreAside) {
    TestCut terrain(test::roughTerrain(700, 300, 90, 1));
    const TerrainCut& cut = terrain.cut();
    const auto rays = test::randomRays(cut, 3000, 1, 5);
    const RaySlack slack{1e-3f, 1e-5f, 1e-3f, 1e-5f};
    for (const auto& shader : test::shaderTraces()) {
        SCOPED_TRACE(shader.name);
        ShaderShares shares;
        const auto hits = traceByShader(cut, rays, shader.trace, shares, slack);
        for (size_t k = 0; k < rays.size(); ++k) {
            const auto exact = oracle::firstHit(cut, rays[k]);
            const auto fault = oracle::judge(cut, rays[k], hits[k], exact);
            EXPECT_FALSE(oracle::isViolation(fault))
                << oracle::describe(fault, rays[k], hits[k], exact);
        }
        EXPECT_LT(shares.share(shares.uncertain), 0.2);
    }
}

TEST(ShaderText, EndsAfterTheMostSteps) {
    TestCut terrain(test::roughTerrain(700, 300, 90, 1));
    const TerrainCut& cut = terrain.cut();
    RayBatch batch;
    batch.set(0, towards({5, 5, 95}, {690, 290, 40}));
    TraceRay ray;
    placeTraceRays(cut, batch, 1, 63, {&ray, 1});
    TraceCut constants = traceCutOf(cut);
    const auto flagsOf = [](const TraceHit& hit) { return hit.stepsMipFlags >> 24; };
    for (const auto& shader : test::shaderTraces()) {
        constants.maxSteps = 20000;
        const TraceHit hit = shader.trace(cut, constants, ray, {});
        ASSERT_EQ(flagsOf(hit) & kHitUncertain, 0u);
        const auto steps = static_cast<int>(hit.stepsMipFlags & 0xFFFFu);
        ASSERT_GT(steps, 4);
        constants.maxSteps = steps;
        EXPECT_EQ(flagsOf(shader.trace(cut, constants, ray, {})), flagsOf(hit));
        constants.maxSteps = steps - 1;
        EXPECT_EQ(flagsOf(shader.trace(cut, constants, ray, {})) & (kHitUncertain | kHitValid),
                  uint32_t{kHitUncertain});
    }
}

/// A head start changes no hit (kernel/beam.h).
TEST(ShaderText, StartsWhereItIsTold) {
    TestCut terrain(test::roughTerrain(700, 300, 90, 1));
    const TerrainCut& cut = terrain.cut();
    const auto rays = test::randomRays(cut, 64, 1, 6);
    RayBatch whole, late;
    TraceRay ray[64];
    TraceHit found[64];
    Hit exact[64], hits[64];
    TraceCounters counters;
    const TraceCut constants = traceCutOf(cut);
    for (const auto& shader : test::shaderTraces())
        for (const int level : {0, 3, 8}) {
            for (int k = 0; k < 64; ++k) whole.set(k, rays[static_cast<size_t>(k)]);
            firstHits(cut, whole, 64, 63, exact, counters);
            for (int k = 0; k < 64; ++k) {
                late.set(k, rays[static_cast<size_t>(k)]);
                if (isHit(exact[k]) && (exact[k].flags & kHitFromBelow) == 0)
                    late.clear[k] = 0.5 * (whole.begin[k] + static_cast<double>(exact[k].t));
            }
            placeTraceRays(cut, late, 64, level, ray);
            for (int k = 0; k < 64; ++k) found[k] = shader.trace(cut, constants, ray[k], {});
            finishTraceHits(cut, late, 64, found, hits, counters);
            for (int k = 0; k < 64; ++k) {
                ASSERT_EQ(isHit(hits[k]), isHit(exact[k])) << k;
                if (isHit(hits[k])) {
                    EXPECT_EQ(hits[k].cell, exact[k].cell) << k;
                }
            }
        }
}

}  // namespace
}  // namespace terray
