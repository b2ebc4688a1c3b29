// SPDX-License-Identifier: Apache-2.0
// Compiles trace_block-inl.h for every SIMD target and dispatches.
#include "kernel/simd/trace_block.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernel/simd/trace_block.cpp"
#include "hwy/foreach_target.h"
// after foreach_target.h
#include "kernel/simd/trace_block-inl.h"

#if HWY_ONCE
#include "kernel/trace.h"

namespace terray::simd {

HWY_EXPORT(traceBlockLanes);

void traceBlock(const TerrainCut& cut, RayBlock& block, int count) {
    HWY_DYNAMIC_DISPATCH(traceBlockLanes)(cut, block, count);
}

}  // namespace terray::simd

namespace terray {
namespace {

/// Targets that this build has and this machine can run, best (lowest bit) first.
std::vector<int64_t> availableTargets() {
    static const int64_t supported = hwy::SupportedTargets();
    std::vector<int64_t> targets;
    for (int bit = 0; bit < 63; ++bit) {
        const int64_t target = int64_t{1} << bit;
        if ((HWY_TARGETS & supported & target) != 0) targets.push_back(target);
    }
    return targets;
}

}  // namespace

std::vector<std::string> simdTargets() {
    std::vector<std::string> names;
    for (const int64_t target : availableTargets()) names.emplace_back(hwy::TargetName(target));
    return names;
}

std::string activeSimdTarget() {
    const int64_t supported = hwy::SupportedTargets();
    for (const int64_t target : availableTargets())
        if ((supported & target) != 0) return hwy::TargetName(target);
    return "none";
}

bool setSimdTarget(const std::string& name) {
    for (const int64_t target : availableTargets()) {
        if (!name.empty() && name != hwy::TargetName(target)) continue;
        hwy::SetSupportedTargetsForTest(name.empty() ? 0 : target);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        return true;
    }
    return false;
}

}  // namespace terray
#endif  // HWY_ONCE
