// SPDX-License-Identifier: Apache-2.0
// Making each part once. Parallel work under the lock is isolated: a thread that waits for it must
// not take up another frame's task, which could wait for the same lock.
#include "shade/shade_cache.h"

#include <oneapi/tbb/task_arena.h>

#include <cmath>

#include "base/stopwatch.h"
#include "shade/light.h"
#include "shade/ramp_builtin.h"

namespace terray {
namespace {

/// Posts of the overview that sky light and ramps are made from.
constexpr int64_t kOverviewPosts = 2'000'000;

/// Sky-light fields kept: that of the picture at hand, and of the one before.
constexpr size_t kSkies = 2;

const Overview& madeOverview(const TerrainCut& cut, const TerrainInfo& info,
                             std::optional<Overview>& overview) {
    if (!overview) overview = ShadeCache::overviewOf(cut, info);
    return *overview;
}

template <class Work>
void isolated(const Work& work) {
    oneapi::tbb::this_task_arena::isolate(work);
}

}  // namespace

int ShadeCache::overviewMip(const TilingScheme& scheme) {
    return terray::overviewMip(scheme, kOverviewPosts);
}

Overview ShadeCache::overviewOf(const TerrainCut& cut, const TerrainInfo& info) {
    return makeOverview(cut, info.scheme, kOverviewPosts);
}

std::shared_ptr<const ShadeCache::Survey> ShadeCache::survey(const TerrainCut& cut,
                                                             const TerrainInfo& info,
                                                             std::optional<Overview>& overview) {
    const std::lock_guard lock(mutex_);
    if (survey_) return survey_;
    isolated([&] {
        const Overview& view = madeOverview(cut, info, overview);
        const double cell = std::ldexp(info.worldFromLattice.columnLength(), view.mip);
        auto made = std::make_shared<Survey>();
        made->heights = surveyHeights(
            {view.heights, view.width, cell, info.minZ, info.maxZ, !info.crsWkt.empty()});
        made->meanSlope = meanSlope(view, info.worldFromLattice);
        survey_ = std::move(made);
    });
    return survey_;
}

std::shared_ptr<const SkyLight> ShadeCache::skyLight(const TerrainCut& cut, const TerrainInfo& info,
                                                     double exaggeration,
                                                     std::optional<Overview>& overview,
                                                     double& madeMs) {
    const std::lock_guard lock(mutex_);
    madeMs = 0;
    for (auto sky = skies_.begin(); sky != skies_.end(); ++sky) {
        if (sky->exaggeration != exaggeration) continue;
        skies_.splice(skies_.begin(), skies_, sky);
        return skies_.front().light;
    }
    const Stopwatch watch;
    isolated([&] {
        madeOverview(cut, info, overview);
        skies_.push_front(
            {exaggeration, std::make_shared<SkyLight>(std::move(*overview), info.worldFromLattice,
                                                      exaggeration)});
    });
    overview.reset();
    if (skies_.size() > kSkies) skies_.pop_back();
    releaseFreedMemory();
    madeMs = watch.elapsedMs();
    return skies_.front().light;
}

std::shared_ptr<const std::vector<RimLoop>> ShadeCache::rims(const TerrainCut& cut,
                                                             const TerrainInfo& info,
                                                             std::optional<Overview>& overview) {
    const std::lock_guard lock(mutex_);
    if (!rims_)
        isolated([&] {
            rims_ = std::make_shared<const std::vector<RimLoop>>(
                outerRims(madeOverview(cut, info, overview)));
        });
    return rims_;
}

std::shared_ptr<const PhotoFilter> ShadeCache::photoFilter(const DrapedPhoto& photo) {
    const std::lock_guard lock(mutex_);
    if (!photo_)
        isolated([&] {
            photo_ = photo.whole != nullptr ? std::make_shared<PhotoFilter>(*photo.whole)
                                            : std::make_shared<PhotoFilter>(*photo.inBlocks);
        });
    return photo_;
}

Result<std::shared_ptr<const ShadeCache::Ramp>> ShadeCache::ramp(const std::string& nameOrFile,
                                                                 const HeightSurvey& survey) {
    const bool kept = nameOrFile.empty() || findBuiltinRamp(nameOrFile) != nullptr;
    const std::lock_guard lock(mutex_);
    if (const auto found = ramps_.find(nameOrFile); kept && found != ramps_.end())
        return found->second;
    auto made = HeightRamp::make(nameOrFile, survey);
    if (!made) return made.error();
    const TintTable tints(*made, kClay);
    auto ramp = std::make_shared<const Ramp>(Ramp{std::move(*made), tints});
    if (kept) ramps_[nameOrFile] = ramp;
    return ramp;
}

}  // namespace terray
