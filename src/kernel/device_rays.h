// SPDX-License-Identifier: Apache-2.0
// The host's two ends of a trace on a device (kernel/glsl/trace.glsl): rays placed in double
// precision before it, and what the device left open decided in double precision after it.
#pragma once

#include <cstdint>
#include <span>

#include "kernel/layout/layout.h"
#include "kernel/ray_batch.h"
#include "kernel/trace.h"

namespace terray {

/// The same bytes as in kernel/glsl/layout.glsl, which says what they mean.
struct TraceCut {
    uint32_t format, surface;
    int32_t rootLevel;
    int32_t cellsX, cellsY;
    float anchorZ, reach, maxDelta, postError, zRounding;
    int32_t maxSteps;
};
struct TraceRay {
    int32_t anchorX, anchorY;
    float fx, fy, dx, dy, z, dz, bend, tEnd, begin;
    int32_t level;
};
struct TraceHit {
    float t;
    uint32_t tile, cell;
    float u, v;
    uint32_t stepsMipFlags;
};
struct RaySlack {
    float place = 0, placePerT = 0, height = 0, heightPerT = 0;
};
static_assert(sizeof(TraceCut) == 44 && sizeof(TraceRay) == 48 && sizeof(TraceHit) == sizeof(Hit));

/// More flags of a device's hit (layout.glsl).
constexpr uint8_t kHitUnderSheet = 32, kHitPlaceOpen = 64, kHitUncertain = 128;

TraceCut traceCutOf(const TerrainCut& cut);

/// Clips the rays of a batch and places the float rays. `level`: as for firstHits.
void placeTraceRays(const TerrainCut& cut, RayBatch& batch, int count, int level,
                    std::span<TraceRay> rays);

/// Hits of the batch's rays from those of the device: exact, as from firstHits. `batch` as
/// placeTraceRays left it; its `above` is set as firstHits does.
void finishTraceHits(const TerrainCut& cut, RayBatch& batch, int count,
                     std::span<const TraceHit> found, std::span<Hit> hits, TraceCounters& counters);

}  // namespace terray
