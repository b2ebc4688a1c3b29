// SPDX-License-Identifier: Apache-2.0
// Sharing out the memory budget.
#include "engine/memory_rule.h"

#include <algorithm>

namespace terray {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;
constexpr uint64_t kGiB = uint64_t{1} << 30;

/// Bands of pixels and shading fields of a frame; measured, with room to spare.
constexpr uint64_t kFrameBytes = 96 * kMiB;

uint64_t budgetBytes(uint64_t asked, uint64_t physical) {
    return asked != 0 ? asked : std::min(2 * kGiB, physical / 2);
}

}  // namespace

uint64_t gdalCacheBytes(uint64_t asked, uint64_t physical) {
    return std::clamp(budgetBytes(asked, physical) / 128, 4 * kMiB, 16 * kMiB);
}

std::string bytesText(uint64_t bytes) {
    const double value = static_cast<double>(bytes);
    if (bytes >= kGiB) return fmt::format("{:.1f} GiB", value / static_cast<double>(kGiB));
    if (bytes >= kMiB) return fmt::format("{:.0f} MiB", value / static_cast<double>(kMiB));
    return fmt::format("{:.0f} KiB", value / 1024.0);
}

StreamPlan planStreaming(bool hasPhoto, uint64_t asked, uint64_t physical) {
    const uint64_t budget = budgetBytes(asked, physical);
    const uint64_t other = gdalCacheBytes(asked, physical) + std::min(kFrameBytes, budget / 4);
    const uint64_t left = budget - std::min(budget, other);
    StreamPlan plan;
    plan.photo = hasPhoto ? left / 4 : 0;
    plan.tiles = (left - plan.photo) / 5 * 4;  // a fifth is left to sun sweeps over them
    return plan;
}

bool fitsWhole(uint64_t required, uint64_t asked, uint64_t physical) {
    const uint64_t budget = budgetBytes(asked, physical);
    return required + gdalCacheBytes(asked, physical) + std::min(kFrameBytes, budget / 4) <= budget;
}

Result<MemoryPlan> planMemory(const std::string& source, uint64_t required, uint64_t asked,
                              uint64_t physical) {
    MemoryPlan plan;
    plan.budget = budgetBytes(asked, physical);
    plan.gdalCache = gdalCacheBytes(asked, physical);
    plan.frame = std::min(kFrameBytes, plan.budget / 4);
    const uint64_t total = required + plan.gdalCache + plan.frame;
    if (total > plan.budget) {
        // At this size the frame takes its full share; round up to what a user would type.
        const uint64_t needed = required + 16 * kMiB + kFrameBytes;
        const uint64_t mib = (needed + 64 * kMiB - 1) / (64 * kMiB) * 64;
        const bool fits = mib * kMiB <= physical;
        const std::string advice =
            fits ? fmt::format("use --memory {}MiB", mib)
                 : fmt::format("this machine has {}: cut out a window with gdal_translate -srcwin",
                               bytesText(physical));
        return makeError(ErrorCode::Input,
                         "'{}' needs about {} of memory, more than the {} of {}; {}", source,
                         bytesText(total), bytesText(plan.budget),
                         asked != 0 ? "--memory" : "the default budget", advice);
    }
    plan.photo = plan.budget - total;
    return plan;
}

}  // namespace terray
