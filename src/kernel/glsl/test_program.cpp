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

/// Moves a ray to a corner of what the slack allows.
void moveAside(TraceRay& ray, const RaySlack& slack, uint64_t corner) {
    const auto side = [corner](int bit) { return (corner >> bit & 1) != 0 ? 1.0f : -1.0f; };
    const float place = 0.9f * slack.place, perT = 0.9f * slack.placePerT;
    ray.fx = std::clamp(ray.fx + side(0) * place, 0.0f, 0.99999994f);
    ray.fy = std::clamp(ray.fy + side(1) * place, 0.0f, 0.99999994f);
    if (ray.dx != 0) ray.dx += side(2) * perT;
    if (ray.dy != 0) ray.dy += side(3) * perT;
    ray.z += side(4) * 0.9f * slack.height;
    ray.dz += side(5) * 0.9f * slack.heightPerT;
}

}  // namespace

std::vector<NamedShaderTrace> shaderTraces() {
    std::vector<NamedShaderTrace> traces{{"shader text", shaderTraceStrict},
                                         {"shader text, noisy", shaderTraceNoisy}};
    if (canContract()) traces.push_back({"shader text, contracted", shaderTraceContracted});
    return traces;
}

std::vector<Hit> traceByShader(const TerrainCut& cut, std::span<const Ray> rays, ShaderTrace trace,
                               ShaderShares& shares, const RaySlack& slack) {
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
            if (slack.place > 0) moveAside(placed[k], slack, first + k);
            found[k] = trace(cut, constants, placed[k], slack);
            test::count(found[k], shares);
        }
        finishTraceHits(cut, batch, n, {found, count}, std::span(hits).subspan(first, count),
                        counters);
    }
    EXPECT_EQ(counters.rays, rays.size());
    return hits;
}

}  // namespace terray::test
