// SPDX-License-Identifier: Apache-2.0
// The shader text compiled as C++: as written, with contracted multiply-adds as a device may do,
// and with arithmetic as bad as one may have. What its tests run.
#pragma once

#include <span>
#include <vector>

#include "kernel/device_rays.h"

namespace terray::test {

/// One ray by the shader text on the cut's own pools.
using ShaderTrace = TraceHit (*)(const TerrainCut& cut, const TraceCut& constants,
                                 const TraceRay& ray, const RaySlack& slack);
TraceHit shaderTraceStrict(const TerrainCut& cut, const TraceCut& constants, const TraceRay& ray,
                           const RaySlack& slack);
TraceHit shaderTraceContracted(const TerrainCut& cut, const TraceCut& constants,
                               const TraceRay& ray, const RaySlack& slack);
TraceHit shaderTraceNoisy(const TerrainCut& cut, const TraceCut& constants, const TraceRay& ray,
                          const RaySlack& slack);

struct NamedShaderTrace {
    const char* name;
    ShaderTrace trace;
};
/// Those that this machine can run.
std::vector<NamedShaderTrace> shaderTraces();

/// What the text alone found, before the host finishes it.
struct ShaderShares {
    long rays = 0, certainHits = 0, certainMisses = 0, placesOpen = 0, uncertain = 0, steps = 0;
    double share(long part) const { return static_cast<double>(part) / static_cast<double>(rays); }
};

/// First hits as a device and its host find them; adds to `shares`. With a slack, the device's rays
/// are moved aside as far as that says.
std::vector<Hit> traceByShader(const TerrainCut& cut, std::span<const Ray> rays, ShaderTrace trace,
                               ShaderShares& shares, const RaySlack& slack = {});

}  // namespace terray::test
