// SPDX-License-Identifier: Apache-2.0
// What shading makes from a terrain and its photo once and keeps from frame to frame.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "shade/overview.h"
#include "shade/photo_filter.h"
#include "shade/ramp.h"
#include "shade/rim.h"
#include "shade/sky.h"

namespace terray {

/// Belongs to one terrain and one photo. None of it depends on a frame's eye or cut, because all
/// mips are resident. synchronised: a second frame waits for what the first one makes.
class ShadeCache {
public:
    struct Survey {
        HeightSurvey heights;
        double meanSlope = 0;
    };
    /// `overview`: made if it is needed and not there yet; the caller may keep it.
    std::shared_ptr<const Survey> survey(const TerrainCut& cut, const TerrainInfo& info,
                                         std::optional<Overview>& overview);
    /// Takes the overview if it must make the field: two grids at once would be the peak of memory.
    /// `madeMs`: time spent on it, 0 if it was there.
    std::shared_ptr<const SkyLight> skyLight(const TerrainCut& cut, const TerrainInfo& info,
                                             double exaggeration, std::optional<Overview>& overview,
                                             double& madeMs);
    /// Outer rims of the ground.
    std::shared_ptr<const std::vector<RimLoop>> rims(const TerrainCut& cut, const TerrainInfo& info,
                                                     std::optional<Overview>& overview);
    std::shared_ptr<const PhotoFilter> photoFilter(const DrapedPhoto& photo);
    /// A ramp, and how it looks on plain ground.
    struct Ramp {
        HeightRamp heights;
        TintTable tints;
    };
    /// Ramps from files are read again each time: a file may change.
    Result<std::shared_ptr<const Ramp>> ramp(const std::string& nameOrFile,
                                             const HeightSurvey& survey);

    /// The mip that all of the above is made from, wholly resident.
    static int overviewMip(const TilingScheme& scheme);
    /// The grid that all of the above is made from.
    static Overview overviewOf(const TerrainCut& cut, const TerrainInfo& info);

private:
    struct SkyOf {
        double exaggeration;
        std::shared_ptr<const SkyLight> light;
    };
    std::mutex mutex_;
    std::shared_ptr<const Survey> survey_;
    std::shared_ptr<const std::vector<RimLoop>> rims_;
    std::list<SkyOf> skies_;  ///< the latest first; few, since each takes megabytes
    std::shared_ptr<const PhotoFilter> photo_;
    std::map<std::string, std::shared_ptr<const Ramp>> ramps_;
};

}  // namespace terray
