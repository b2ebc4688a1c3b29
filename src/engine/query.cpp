// SPDX-License-Identifier: Apache-2.0
// Heights, rays and lines of sight on the finest cut, by the same kernel as pictures.
#include "terray/query.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <new>

#include "base/interrupt.h"
#include "engine/places.h"
#include "engine/terrain_state.h"
#include "kernel/height.h"
#include "kernel/trace.h"
#include "view/ray_frame.h"

namespace terray {
namespace {

/// The ends of a line of sight that stand on the ground are taken this much above it, so that the
/// ground they stand on does not block them. Metres.
constexpr double kGroundClearance = 1e-3;

struct Asked {
    WorldPoint origin;
    Vec3 direction;  ///< not zero; any length
    double length;   ///< of interest, metres
};

/// One query: places and rays on the finest cut. confined.
class Query {
public:
    static Result<Query> make(const Terrain::State& state, const QueryOptions& options) {
        if (!std::isfinite(options.refraction) || options.refraction < -1 ||
            options.refraction > 0.99)
            return makeError(ErrorCode::Usage, "--refraction: {} is out of range; give -1 to 0.99",
                             options.refraction);
        auto places = PlaceResolver::make(state, options.lonLat, options.surface);
        if (!places) return places.error();
        const bool hasCrs = places->frame().hasCrs();
        if (options.curvature.value_or(false) && !hasCrs)
            return makeError(
                ErrorCode::Usage,
                "--curvature on: without a CRS the size of the globe is not known; name "
                "it with --assign-crs EPSG:n");
        const double radius = options.curvature.value_or(hasCrs)
                                  ? places->frame().curvatureRadius(state.worldCentre())
                                  : 0.0;
        const double bend = radius > 0 ? (1 - options.refraction) / (2 * radius) : 0.0;
        return Query(state, options, std::move(*places), bend);
    }

    const PlaceResolver& places() const { return places_; }
    double bend() const { return bend_; }

    Result<std::vector<QueryHit>> trace(std::span<const Asked> asked) const {
        std::vector<Ray> rays;
        rays.reserve(asked.size());
        for (const Asked& a : asked) {
            rays.push_back(frame_.latticeRay({a.origin, glm::normalize(a.direction)}));
            rays.back().tMax = a.length;
        }
        std::vector<QueryHit> result(rays.size());
        if (state_.resident->streamer() != nullptr) {
            const auto found = [&](size_t k, const TerrainCut& cut,
                                   const Hit& hit) -> Result<void> {
                auto described = describe(cut, rays[k], asked[k].direction, hit);
                if (!described) return described.error();
                result[k] = *described;
                return {};
            };
            TERRAY_TRY(firstHitsFar(*state_.resident, surface_, rays, found));
            return result;
        }
        std::vector<Hit> hits(rays.size());
        constexpr size_t kChunk = 1024;
        tbb::parallel_for(
            tbb::blocked_range<size_t>(0, rays.size(), kChunk), [&](const auto& range) {
                if (isInterrupted()) return;
                TraceCounters counters;
                firstHits(cut_.cut(), std::span(rays).subspan(range.begin(), range.size()),
                          std::span(hits).subspan(range.begin(), range.size()), counters);
            });
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        for (size_t k = 0; k < rays.size(); ++k) {
            if (!isHit(hits[k])) continue;
            auto hit = describe(cut_.cut(), rays[k], asked[k].direction, hits[k]);
            if (!hit) return hit.error();
            result[k] = *hit;
        }
        return result;
    }

private:
    Query(const Terrain::State& state, const QueryOptions& options, PlaceResolver places,
          double bend)
        : state_(state),
          surface_(options.surface == Surface::Constant ? kSurfaceConstant : kSurfaceBilinear),
          places_(std::move(places)),
          frame_(Camera{}, state.resident->info().worldFromLattice, 1.0, bend),
          bend_(bend) {
        if (state.resident->streamer() == nullptr) cut_ = finestCut(*state.resident, surface_);
    }

    Result<QueryHit> describe(const TerrainCut& cut, const Ray& ray, const Vec3& direction,
                              const Hit& hit) const {
        QueryHit q;
        q.hit = true;
        q.distance = static_cast<double>(hit.t);
        q.fromBelow = (hit.flags & kHitFromBelow) != 0;
        const LatticePlace place = hitPlace(cut, hit);
        const Vec2 world = frame_.worldFromLattice().worldFromLattice({place.i, place.j});
        auto data = places_.dataFromWorld(world);
        if (!data) return data.error();
        q.x = data->x;
        q.y = data->y;
        const bool wall = (hit.flags & kHitStrip) != 0;
        q.z = wall ? RayFrame::heightAt(ray, q.distance) : hitHeight(cut, hit);
        const Vec3 normal = wall ? frame_.wallNormal(hit, direction) : groundNormal(cut, hit);
        q.normalX = normal.x;
        q.normalY = normal.y;
        q.normalZ = normal.z;
        return q;
    }

    Vec3 groundNormal(const TerrainCut& cut, const Hit& hit) const {
        if (cut.surface == kSurfaceConstant) return {0, 0, 1};
        const TileDesc& tile = cut.tiles[hit.tile];
        const int x = static_cast<int>(cellX(hit)), y = static_cast<int>(cellY(hit));
        const auto post = [&](int i, int j) {
            return static_cast<double>(postHeight(cut, tile, x + i, y + j));
        };
        const double h00 = post(0, 0), h10 = post(1, 0), h01 = post(0, 1), h11 = post(1, 1);
        const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
        const double size = std::ldexp(1.0, hit.mip);
        const Vec2 slope = frame_.worldFromLattice().worldGradient(
            std::lerp(h10 - h00, h11 - h01, v) / size, std::lerp(h01 - h00, h11 - h10, u) / size);
        return glm::normalize(Vec3{-slope.x, -slope.y, 1});
    }

    const Terrain::State& state_;
    SurfaceKind surface_;
    FrameCut cut_;  ///< mip 0 everywhere, where all tiles are resident
    PlaceResolver places_;
    RayFrame frame_;
    double bend_;
};

/// Runs a query in the terrain's arena; bad_alloc becomes an Error.
template <class T, class Work>
Result<T> inArena(const Terrain& terrain, const QueryOptions& options, Work work) {
    try {
        Result<T> result = T{};
        const auto held = terrain.state().holdTiles();
        terrain.state().arena.execute([&] {
            auto query = Query::make(terrain.state(), options);
            if (query)
                result = work(*query);
            else
                result = query.error();
        });
        return result;
    } catch (const std::bad_alloc&) {
        return makeError(ErrorCode::Resource, "the machine ran out of memory while answering");
    }
}

std::string numbered(const char* what, size_t index) {
    return fmt::format("{} {}", what, index + 1);
}

Result<WorldPoint> sightEnd(const Query& query, const Place& place, const std::string& what) {
    auto point = query.places().resolve(place, what);
    if (!point) return point.error();
    const auto ground = query.places().groundHeight({point->x, point->y});
    if (ground && std::abs(point->z - *ground) < kGroundClearance)
        point->z = *ground + kGroundClearance;
    return *point;
}

}  // namespace

Result<std::vector<double>> queryHeights(const Terrain& terrain, std::span<const Place> places,
                                         const QueryOptions& options) {
    using Heights = std::vector<double>;
    return inArena<Heights>(terrain, options, [&](const Query& query) -> Result<Heights> {
        Heights heights;
        heights.reserve(places.size());
        for (size_t k = 0; k < places.size(); ++k) {
            auto world =
                query.places().resolveHorizontal({places[k].x, places[k].y}, numbered("point", k));
            if (!world) return world.error();
            heights.push_back(query.places().groundHeight(*world).value_or(
                std::numeric_limits<double>::quiet_NaN()));
        }
        return heights;
    });
}

Result<std::vector<QueryHit>> queryRays(const Terrain& terrain, std::span<const QueryRay> rays,
                                        const QueryOptions& options) {
    using Hits = std::vector<QueryHit>;
    return inArena<Hits>(terrain, options, [&](const Query& query) -> Result<Hits> {
        std::vector<Asked> asked;
        asked.reserve(rays.size());
        for (size_t k = 0; k < rays.size(); ++k) {
            const std::string what = numbered("ray", k);
            if (!std::isfinite(rays[k].headingDeg) || !(std::abs(rays[k].pitchDeg) <= 90))
                return makeError(ErrorCode::Usage,
                                 "{}: heading {} or pitch {} is out of range; pitch is -90 to 90 "
                                 "degrees, up positive",
                                 what, rays[k].headingDeg, rays[k].pitchDeg);
            auto origin = query.places().resolve(rays[k].origin, what);
            if (!origin) return origin.error();
            const double h = radFromDeg(rays[k].headingDeg), p = radFromDeg(rays[k].pitchDeg);
            asked.push_back({*origin,
                             {std::sin(h) * std::cos(p), std::cos(h) * std::cos(p), std::sin(p)},
                             Ray{}.tMax});
        }
        return query.trace(asked);
    });
}

Result<std::vector<LineOfSight>> queryLinesOfSight(const Terrain& terrain,
                                                   std::span<const Place> from,
                                                   std::span<const Place> to,
                                                   const QueryOptions& options) {
    using Lines = std::vector<LineOfSight>;
    if (from.size() != to.size())
        return makeError(ErrorCode::Usage, "line-of-sight: {} places to see from, but {} to see",
                         from.size(), to.size());
    return inArena<Lines>(terrain, options, [&](const Query& query) -> Result<Lines> {
        Lines lines(from.size());
        std::vector<Asked> asked;
        asked.reserve(from.size());
        for (size_t k = 0; k < from.size(); ++k) {
            auto eye = sightEnd(query, from[k], numbered("line", k) + ", first place");
            if (!eye) return eye.error();
            auto target = sightEnd(query, to[k], numbered("line", k) + ", second place");
            if (!target) return target.error();
            Vec3 direction = *target - *eye;
            lines[k].distance = glm::length(direction);
            if (!(lines[k].distance > 0))
                return makeError(ErrorCode::Usage, "line {}: both places are the same", k + 1);
            // The bent ray that ends at the target starts lower by its whole bend.
            direction.z -= query.bend() * (direction.x * direction.x + direction.y * direction.y);
            asked.push_back({*eye, direction, glm::length(direction)});
        }
        auto hits = query.trace(asked);
        if (!hits) return hits.error();
        for (size_t k = 0; k < lines.size(); ++k) {
            lines[k].visible = !(*hits)[k].hit;
            lines[k].blockedAt = (*hits)[k];
        }
        return lines;
    });
}

}  // namespace terray
