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

HWY_EXPORT(startShadowLanes);
HWY_EXPORT(leaveShadowLanes);
HWY_EXPORT(walkShadowLanes);

int startShadows(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, const SunAsks& asks,
                 int first, ShadowBlock& hits, uint8_t* verdicts) {
    return HWY_DYNAMIC_DISPATCH(startShadowLanes)(cut, sweep, slot, asks, first, hits, verdicts);
}

uint64_t leaveHits(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, bool all,
                   ShadowBlock& hits, ShadowBlock& block, ShadowLeaving& leaving,
                   uint8_t* verdicts) {
    return HWY_DYNAMIC_DISPATCH(leaveShadowLanes)(cut, sweep, slot, all, hits, block, leaving,
                                                  verdicts);
}

uint64_t walkShadows(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, int rest,
                     ShadowBlock& block, ShadowLeaving& leaving, uint8_t* verdicts) {
    return HWY_DYNAMIC_DISPATCH(walkShadowLanes)(cut, sweep, slot, rest, block, leaving, verdicts);
}

}  // namespace terray::simd
#endif  // HWY_ONCE
