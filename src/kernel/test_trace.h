// SPDX-License-Identifier: Apache-2.0
// What the tests of the tracer share: rays to try, and the oracle's verdict on every SIMD target.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "kernel/scalar/oracle.h"
#include "kernel/trace.h"

namespace terray::test {

using Random = std::mt19937_64;
inline double uniform(Random& random, double low, double high) {
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

/// First hits by the active target.
std::vector<Hit> trace(const TerrainCut& cut, const std::vector<Ray>& rays);

/// Every ray on every target, and by the shader text, like the oracle. Returns the oracle's hits.
/// Random rays do not tie.
std::vector<oracle::ExactHit> expectLikeOracle(const TerrainCut& cut, const std::vector<Ray>& rays,
                                               int maxTies = 0);

/// Every shadow ray on every target like the oracle. Returns how many are occluded.
long expectShadowsLikeOracle(const TerrainCut& cut, const std::vector<Hit>& hits,
                             const std::vector<Ray>& suns);

using Place = std::array<double, 3>;
/// `scale`: lattice cells a metre, so that t counts metres.
Ray towards(const Place& from, const Place& to, double scale = 1, double bend = 0);

/// Where a hit lies: on the sheet, or at the ray's height on a strip or wall.
Place placeOf(const TerrainCut& cut, const Ray& ray, const Hit& hit);

/// Random rays: eyes inside, beside, above and below the box; targets near the sheet.
std::vector<Ray> randomRays(const TerrainCut& cut, int count, double scale, uint64_t seed);

}  // namespace terray::test
