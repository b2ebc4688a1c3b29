// SPDX-License-Identifier: Apache-2.0
// The joint lattice of unlike DEMs, and the reader that lays them over each other.
#include "raster/dem_mosaic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>

#include "raster/dem_description.h"
#include "raster/warp.h"

namespace terray {
namespace {

constexpr int kProbes = 33;              ///< places a side at which extents are mapped
constexpr double kMostEmptiness = 64;    ///< posts for each sample of a DEM
constexpr size_t kOpenReaders = 4;       ///< of a reader of the mosaic
constexpr int64_t kPreferredRows = 512;  ///< rows of the lattice slant through those of the files
constexpr double kSamePlace = 1e-3;      ///< of a post

/// A DEM on the joint lattice, and the posts that it may reach.
struct Part {
    WarpPlan plan;
    int64_t left = 0, top = 0, right = 0, bottom = 0;
};

/// confined.
class MosaicReader final : public HeightReader {
public:
    MosaicReader(std::string name, const std::vector<Part>& parts)
        : name_(std::move(name)), parts_(parts) {}

    Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height,
                      std::span<float> posts) override {
        std::fill(posts.begin(), posts.end(), std::numeric_limits<float>::quiet_NaN());
        for (size_t k = 0; k < parts_.size(); ++k) {
            const Part& part = parts_[k];
            const int64_t left = std::max(column, part.left), top = std::max(row, part.top);
            const int64_t right = std::min(column + width, part.right);
            const int64_t bottom = std::min(row + height, part.bottom);
            if (left >= right || top >= bottom) continue;
            auto reader = readerOf(k);
            if (!reader) return reader.error();
            scratch_.resize(static_cast<size_t>((right - left) * (bottom - top)));
            TERRAY_TRY((*reader)->read(left, top, right - left, bottom - top, scratch_));
            const float* from = scratch_.data();
            for (int64_t j = top; j < bottom; ++j) {
                float* to = posts.data() + (j - row) * width + (left - column);
                for (int64_t i = left; i < right; ++i, ++from, ++to) {
                    if (!std::isnan(*from)) *to = *from;
                }
            }
        }
        return {};
    }

    Result<void> readCodes(int64_t, int64_t, int64_t, int64_t, std::span<uint16_t>) override {
        return makeError(ErrorCode::Failed, "'{}' is warped: its posts are floats, not codes",
                         name_);
    }

private:
    Result<HeightReader*> readerOf(size_t part) {
        const auto found = std::find_if(readers_.begin(), readers_.end(),
                                        [&](const auto& open) { return open.first == part; });
        if (found != readers_.end()) {
            readers_.splice(readers_.begin(), readers_, found);
            return readers_.front().second.get();
        }
        auto reader = makeWarpReader(parts_[part].plan);
        if (!reader) return reader.error();
        readers_.emplace_front(part, std::move(*reader));
        if (readers_.size() > kOpenReaders) readers_.pop_back();
        return readers_.front().second.get();
    }

    std::string name_;
    const std::vector<Part>& parts_;
    std::list<std::pair<size_t, std::unique_ptr<HeightReader>>> readers_;  ///< last used first
    std::vector<float> scratch_;
};

/// const-shared.
class MosaicSource final : public HeightSource {
public:
    MosaicSource(TerrainInfo info, std::vector<Part> parts)
        : info_(std::move(info)), parts_(std::move(parts)) {}
    const TerrainInfo& info() const override { return info_; }
    Result<std::unique_ptr<HeightReader>> makeReader() const override {
        return std::unique_ptr<HeightReader>(new MosaicReader(info_.name, parts_));
    }
    int64_t preferredRows() const override { return kPreferredRows; }

private:
    TerrainInfo info_;
    std::vector<Part> parts_;
};

Result<std::vector<Description>> describeAll(std::span<const std::string> names,
                                             const OpenOptions& options) {
    std::vector<Description> all;
    for (const std::string& name : names) {
        Result<Description> described = describeDem(name, options);
        if (!described) return described.error();
        if (!described->header.transform) {
            return makeError(ErrorCode::Input,
                             "'{}' has no georeference: several DEMs are joined by their places",
                             name);
        }
        all.push_back(std::move(*described));
        if (all.front().crs.has_value() == all.back().crs.has_value()) continue;
        const bool isFirst = !all.front().crs;
        return makeError(ErrorCode::Input,
                         "'{}' has no CRS, but '{}' has one; name it with --assign-crs if all have "
                         "the same, or write it into the file with gdal_edit -a_srs",
                         isFirst ? names[0] : name, isFirst ? name : names[0]);
    }
    return all;
}

/// Extent of all DEMs in the CRS of the first one, in its units.
Result<Extent2> jointExtent(const std::vector<Description>& all) {
    const Description& first = all.front();
    Extent2 joint = extentOf(first.header, first.dataFromSample);
    for (const Description& d : all) {
        const Result<GeoFrame> frame = GeoFrame::make(d.crs->wkt, first.crs->wkt);
        if (!frame) {
            return makeError(frame.error().code, "'{}': {}", d.header.name, frame.error().message);
        }
        const Extent2 own = extentOf(d.header, d.dataFromSample);
        for (int k = 0; k < kProbes * kProbes; ++k) {
            const Vec2 share = Vec2(k % kProbes, k / kProbes) / double(kProbes - 1);
            const Result<Vec2> place = frame->worldFromData(own.min + share * (own.max - own.min));
            if (!place) continue;
            const Vec2 p = *place / first.crs->metresPerUnit;
            joint.min = glm::min(joint.min, p);
            joint.max = glm::max(joint.max, p);
        }
    }
    return joint;
}

/// Chooses the working CRS for all; nothing without any CRS.
Result<void> placeAll(const std::vector<Description>& all, const OpenOptions& options,
                      TerrainInfo& info, SourceInfo& facts) {
    const Description& first = all.front();
    facts.workingCrsName = facts.crsName;
    if (!first.crs) return {};
    const Result<Extent2> extent = jointExtent(all);
    if (!extent) return extent.error();
    const Result<WorkingCrs> working =
        chooseWorkingCrs(*first.crs, extent->min, extent->max, options.workingCrs);
    if (!working) {
        return makeError(working.error().code, "'{}' and {} more: {}", first.header.name,
                         all.size() - 1, working.error().message);
    }
    info.crsWkt = working->same ? first.crs->wkt : working->wkt;
    facts.workingCrsName = working->name;
    if (!working->same) facts.assumptions.push_back({working->reason});
    const Result<CrsFacts> target = describeCrs(info.crsWkt);
    if (!target) return target.error();
    info.metresPerCrsUnit = target->metresPerUnit;
    return {};
}

Result<std::vector<Part>> planEach(const std::vector<Description>& all, const TerrainInfo& info) {
    std::vector<Part> parts;
    for (const Description& d : all) {
        const Extent2 extent = extentOf(d.header, d.dataFromSample);
        Part part;
        part.plan = WarpPlan{d.header,
                             d.crs ? d.crs->wkt : std::string(),
                             info.crsWkt,
                             d.dataFromSample,
                             0.5 * (extent.min + extent.max),
                             0,
                             0,
                             {}};
        TERRAY_TRY(planLattice(part.plan));
        parts.push_back(std::move(part));
    }
    return parts;
}

double cellOf(const Part& part) { return part.plan.worldFromLattice.column.x; }

/// The lattice of the finest DEM, continued over all of them; each part learns its posts.
Result<void> joinLattices(std::vector<Part>& parts, TerrainInfo& info) {
    const Part& finest =
        *std::min_element(parts.begin(), parts.end(),
                          [](const Part& a, const Part& b) { return cellOf(a) < cellOf(b); });
    const double cell = cellOf(finest);
    const Vec2 anchor = finest.plan.worldFromLattice.origin;
    Vec2 least(HUGE_VAL), most(-HUGE_VAL);  // in cells from the anchor, x right and y down
    double samples = 0;
    for (Part& part : parts) {
        const WarpPlan& plan = part.plan;
        const Vec2 origin = plan.worldFromLattice.origin;
        // from the middle of its first post to that of its last one, and half a post of its own
        // less half a joint one further: there its outermost pixels end
        const double rim = 0.5 * cellOf(part) / cell - 0.5;
        const Vec2 from = Vec2(origin.x - anchor.x, anchor.y - origin.y) / cell - rim;
        const Vec2 size =
            Vec2(static_cast<double>(plan.columns - 1), static_cast<double>(plan.rows - 1)) *
                (cellOf(part) / cell) +
            2 * rim;
        const Vec2 lo = glm::floor(from + kSamePlace), hi = glm::ceil(from + size - kSamePlace);
        part.left = static_cast<int64_t>(lo.x), part.top = static_cast<int64_t>(lo.y);
        part.right = static_cast<int64_t>(hi.x) + 1, part.bottom = static_cast<int64_t>(hi.y) + 1;
        least = glm::min(least, lo), most = glm::max(most, hi);
        samples += static_cast<double>(plan.header.columns) * static_cast<double>(plan.header.rows);
    }
    const Vec2 count = most - least + 1.0;
    if (count.x * count.y > kMostEmptiness * samples + 4096) {
        return makeError(ErrorCode::Input,
                         "'{}' and {} more lie too far apart for one terrain of {:.4g} m between "
                         "posts ({:.3g} posts for {:.3g} samples); bake them one by one",
                         parts[0].plan.header.name, parts.size() - 1, cell, count.x * count.y,
                         samples);
    }
    info.scheme = {std::max<int64_t>(std::llround(count.x), 2),
                   std::max<int64_t>(std::llround(count.y), 2)};
    info.worldFromLattice = {
        {anchor.x + least.x * cell, anchor.y - least.y * cell}, {cell, 0}, {0, -cell}};
    for (Part& part : parts) {
        part.plan.worldFromLattice = info.worldFromLattice;
        part.plan.columns = info.scheme.columns, part.plan.rows = info.scheme.rows;
        const auto left = static_cast<int64_t>(least.x), top = static_cast<int64_t>(least.y);
        part.left -= left, part.right -= left, part.top -= top, part.bottom -= top;
    }
    return {};
}

}  // namespace

Result<Dem> openUnlikeDems(std::span<const std::string> names, const OpenOptions& options) {
    const Result<std::vector<Description>> all = describeAll(names, options);
    if (!all) return all.error();
    Dem dem;
    dem.facts = factsOf(all->front());
    dem.dataCrsWkt = dem.facts.crsWkt;
    for (size_t k = 1; k < all->size(); ++k) {
        for (const Assumption& assumption : (*all)[k].assumptions) {
            dem.facts.assumptions.push_back(assumption);
        }
    }
    TerrainInfo info;
    info.name = names[0];
    TERRAY_TRY(placeAll(*all, options, info, dem.facts));
    auto parts = planEach(*all, info);
    if (!parts) return parts.error();
    TERRAY_TRY(joinLattices(*parts, info));
    const Result<double> radius = radiusAtCentre(all->front(), info);
    if (!radius) return radius.error();
    info.ellipsoidRadius = *radius;
    dem.facts.warped = true;
    dem.facts.assumptions.push_back(
        {fmt::format("DEMs of unlike lattices: warped to {:.4g} m between posts, the last named "
                     "one on top",
                     info.worldFromLattice.column.x)});
    finishFacts(info, dem.facts);
    dem.notPlain = "there are several";
    dem.source = std::make_unique<MosaicSource>(std::move(info), std::move(*parts));
    return dem;
}

}  // namespace terray
