// SPDX-License-Identifier: Apache-2.0
// Compiles shadow_lanes-inl.h for every SIMD target and dispatches.
#include "kernel/simd/shadow_lanes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernel/simd/shadow_lanes.cpp"
#include "hwy/foreach_target.h"
// after foreach_target.h
#include "kernel/simd/shadow_lanes-inl.h"

#if HWY_ONCE
namespace terray::simd {

HWY_EXPORT(walkShadowLanes);

uint64_t walkShadows(const TerrainCut& cut, const SunSweep& sweep, const SweptTile& tile,
                     ShadowBlock& block, int count, bool atHits, int32_t* results,
                     ShadowBlock& leaving, int& leavingCount) {
    return HWY_DYNAMIC_DISPATCH(walkShadowLanes)(cut, sweep, tile, block, count, atHits, results,
                                                 leaving, leavingCount);
}

}  // namespace terray::simd
#endif  // HWY_ONCE
