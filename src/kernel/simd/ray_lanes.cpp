// SPDX-License-Identifier: Apache-2.0
// Compiles ray_lanes-inl.h for every SIMD target and dispatches.
#include "kernel/simd/ray_lanes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernel/simd/ray_lanes.cpp"
#include "hwy/foreach_target.h"
// after foreach_target.h
#include "kernel/simd/ray_lanes-inl.h"

#if HWY_ONCE
namespace terray::simd {

HWY_EXPORT(placeRayBatch);
HWY_EXPORT(finishHitLanes);

void placeRays(const TerrainCut& cut, RayBatch& rays, RayBlock& block, int count, int level) {
    HWY_DYNAMIC_DISPATCH(placeRayBatch)(cut, rays, block, count, level);
}
void finishHits(const RayBatch& rays, HitLanes& hits, int count, SurfaceKind surface) {
    HWY_DYNAMIC_DISPATCH(finishHitLanes)(rays, hits, count, surface);
}

}  // namespace terray::simd
#endif  // HWY_ONCE
