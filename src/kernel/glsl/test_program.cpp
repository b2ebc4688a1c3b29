// SPDX-License-Identifier: Apache-2.0
// A device made of the shader text in C++.
#include "kernel/glsl/test_program.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace terray::test {
namespace {

bool canContract() {
#if defined(__x86_64__)
    return __builtin_cpu_supports("fma") != 0;
#else
    return true;
#endif
}

void count(const TraceHit& hit, ShaderShares& shares) {
    const uint32_t flags = hit.stepsMipFlags >> 24;
    shares.steps += hit.stepsMipFlags & 0xFFFFu;
    ++shares.rays;
    if ((flags & kHitUncertain) != 0)
        ++shares.uncertain;
    else if ((flags & kHitPlaceOpen) != 0)
        ++shares.placesOpen;
    else
        ++((flags & kHitValid) != 0 ? shares.certainHits : shares.certainMisses);
    EXPECT_FALSE((flags & kHitUncertain) != 0 && (flags & kHitValid) != 0);
    EXPECT_TRUE(std::isfinite(hit.t) && std::isfinite(hit.u) && std::isfinite(hit.v));
}

}  // namespace

std::vector<NamedShaderTrace> shaderTraces() {
    std::vector<NamedShaderTrace> traces{{"shader text", shaderTraceStrict},
                                         {"shader text, noisy", shaderTraceNoisy}};
    if (canContract()) traces.push_back({"shader text, contracted", shaderTraceContracted});
    return traces;
}

std::vector<Hit> traceByShader(const TerrainCut& cut, std::span<const Ray> rays, ShaderTrace trace,
                               ShaderShares& shares) {
    std::vector<Hit> hits(rays.size());
    const TraceCut constants = traceCutOf(cut);
    RayBatch batch;
    TraceRay placed[kBatchRays];
    TraceHit found[kBatchRays];
    TraceCounters counters;
    for (size_t first = 0; first < rays.size(); first += kBatchRays) {
        const size_t count = std::min<size_t>(kBatchRays, rays.size() - first);
        const auto n = static_cast<int>(count);
        for (size_t k = 0; k < count; ++k) batch.set(static_cast<int>(k), rays[first + k]);
        placeTraceRays(cut, batch, n, 63, placed);
        for (size_t k = 0; k < count; ++k) {
            found[k] = trace(cut, constants, placed[k]);
            test::count(found[k], shares);
        }
        finishTraceHits(cut, batch, n, {found, count}, std::span(hits).subspan(first, count),
                        counters);
    }
    EXPECT_EQ(counters.rays, rays.size());
    return hits;
}

}  // namespace terray::test
