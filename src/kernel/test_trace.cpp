// SPDX-License-Identifier: Apache-2.0
// Rays for the tests of the tracer, judged by the oracle.
#include "kernel/test_trace.h"

#include <algorithm>
#include <cmath>

#include "kernel/glsl/test_program.h"
#include "kernel/height.h"
#include "kernel/scalar/judge.h"

namespace terray::test {

using oracle::ExactHit;
using oracle::Fault;

std::vector<Hit> trace(const TerrainCut& cut, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    TraceCounters counters;
    firstHits(cut, rays, hits, counters);
    EXPECT_EQ(counters.rays, rays.size());
    EXPECT_EQ(counters.hits, static_cast<uint64_t>(std::count_if(hits.begin(), hits.end(), isHit)));
    return hits;
}

namespace {

void expectLikeExact(const TerrainCut& cut, const std::vector<Ray>& rays,
                     const std::vector<Hit>& hits, const std::vector<ExactHit>& exact,
                     int maxTies) {
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
}

}  // namespace

std::vector<ExactHit> expectLikeOracle(const TerrainCut& cut, const std::vector<Ray>& rays,
                                       int maxTies) {
    std::vector<ExactHit> exact(rays.size());
    std::transform(rays.begin(), rays.end(), exact.begin(),
                   [&cut](const Ray& ray) { return oracle::firstHit(cut, ray); });
    forEachTarget([&] { expectLikeExact(cut, rays, trace(cut, rays), exact, maxTies); });
    for (const NamedShaderTrace& shader : shaderTraces()) {
        SCOPED_TRACE(shader.name);
        ShaderShares shares;
        expectLikeExact(cut, rays, traceByShader(cut, rays, shader.trace, shares), exact, maxTies);
    }
    return exact;
}

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

Ray towards(const Place& from, const Place& to, double scale, double bend) {
    const double x = (to[0] - from[0]) / scale, y = (to[1] - from[1]) / scale, z = to[2] - from[2];
    const double length = std::hypot(x, y, z);
    const double horizontal = (x * x + y * y) / (length * length);
    return {from[0],    from[1],          from[2], x / length * scale, y / length * scale,
            z / length, bend * horizontal};
}

Place placeOf(const TerrainCut& cut, const Ray& ray, const Hit& hit) {
    const LatticePlace place = hitPlace(cut, hit);
    const double t = static_cast<double>(hit.t);
    const bool strip = (hit.flags & kHitStrip) != 0;
    return {place.i, place.j, strip ? ray.z + (ray.dz + ray.bend * t) * t : hitHeight(cut, hit)};
}

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

}  // namespace terray::test
