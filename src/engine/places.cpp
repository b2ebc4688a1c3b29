// SPDX-License-Identifier: Apache-2.0
// Resolving places and views.
#include "engine/places.h"

#include <algorithm>
#include <cmath>

#include "base/log.h"
#include "kernel/height.h"

namespace terray {

Result<PlaceResolver> PlaceResolver::make(const Terrain::State& state, bool lonLat,
                                          Surface surface) {
    auto frame = state.makeGeoFrame();
    if (!frame) return frame.error();
    if (lonLat && !frame->hasCrs())
        return makeError(ErrorCode::Usage,
                         "--lonlat: '{}' has no CRS, so degrees have no place in it; name it with "
                         "--assign-crs EPSG:n",
                         state.facts.source);
    return PlaceResolver(state, std::move(*frame), lonLat, surface);
}

Result<Vec2> PlaceResolver::resolveHorizontal(Vec2 xy, const std::string& what) const {
    auto world = lonLat_ ? frame_.worldFromLonLat(xy) : frame_.worldFromData(xy);
    if (!world)
        return makeError(ErrorCode::Usage, "{}: {}, {} has no place in the working CRS ({})", what,
                         xy.x, xy.y, world.error().message);
    if (!std::isfinite(world->x) || !std::isfinite(world->y))
        return makeError(ErrorCode::Usage, "{}: {}, {} has no place in the working CRS", what, xy.x,
                         xy.y);
    return *world;
}

Result<Vec2> PlaceResolver::dataFromWorld(Vec2 world) const {
    return lonLat_ ? frame_.lonLatFromWorld(world) : frame_.dataFromWorld(world);
}

std::optional<double> PlaceResolver::groundHeight(Vec2 world) const {
    const LatticePoint at = state_->resident->info().worldFromLattice.latticeFromWorld(world);
    const SurfaceCell cell = state_->ground->cellAt(at.i, at.j);
    if (cell.slot == kNoSlot) return std::nullopt;
    return cell.height(surface_ == Surface::Constant ? kSurfaceConstant : kSurfaceBilinear);
}

Result<WorldPoint> PlaceResolver::resolve(const Place& place, const std::string& what) const {
    auto world = resolveHorizontal({place.x, place.y}, what);
    if (!world) return world.error();
    if (place.z && !place.aboveGround) return WorldPoint{world->x, world->y, *place.z};
    const std::optional<double> ground = groundHeight(*world);
    if (!ground)
        return makeError(ErrorCode::Usage,
                         "{}: there is no ground at {}, {} to count the height from (outside, or a "
                         "hole); give an absolute Z in metres",
                         what, place.x, place.y);
    return WorldPoint{world->x, world->y, *ground + place.z.value_or(0.0)};
}

namespace {

Place pictureSpace(const WorldPoint& p, double exaggeration) {
    return {p.x, p.y, p.z * exaggeration, false};
}

/// Bounding rectangle in the world of a rectangle in the data's CRS: its edges may bend.
Result<Extent> resolveExtent(const PlaceResolver& places, const Extent& extent) {
    constexpr int kSteps = 16;
    Extent box;
    bool first = true;
    for (int k = 0; k <= kSteps; ++k) {
        const double s = static_cast<double>(k) / kSteps;
        const double x = std::lerp(extent.xMin, extent.xMax, s);
        const double y = std::lerp(extent.yMin, extent.yMax, s);
        for (const Vec2 p : {Vec2{x, extent.yMin}, Vec2{x, extent.yMax}, Vec2{extent.xMin, y},
                             Vec2{extent.xMax, y}}) {
            auto w = places.resolveHorizontal(p, "--extent");
            if (!w) return w.error();
            if (first) box = {w->x, w->y, w->x, w->y};
            first = false;
            box = {std::min(box.xMin, w->x), std::min(box.yMin, w->y), std::max(box.xMax, w->x),
                   std::max(box.yMax, w->y)};
        }
    }
    return box;
}

/// A panorama without an eye stands in the middle, a little above the ground.
WorldPoint defaultPanoramaEye(const Terrain::State& state, const PlaceResolver& places) {
    const TerrainInfo& info = state.resident->info();
    const Vec2 centre = state.worldCentre();
    const double relief = static_cast<double>(info.maxZ) - static_cast<double>(info.minZ);
    const double above = std::max(2.0, 0.1 * relief);
    const double ground = places.groundHeight(centre).value_or(static_cast<double>(info.maxZ));
    log::note(
        "the panorama is seen from the centre of the terrain, {:.0f} m above the ground (choose a "
        "place with --eye)",
        above);
    return {centre.x, centre.y, ground + above};
}

}  // namespace

Result<View> resolveView(const Terrain::State& state, const PlaceResolver& places, const View& view,
                         double exaggeration) {
    View resolved = view;
    resolved.lonLat = false;
    if (view.extent) {
        auto extent = resolveExtent(places, *view.extent);
        if (!extent) return extent.error();
        resolved.extent = *extent;
    }
    std::optional<WorldPoint> eye;
    if (view.eye) {
        auto point = places.resolve(*view.eye, "--eye");
        if (!point) return point.error();
        eye = *point;
    } else if (view.projection == Projection::Panorama) {
        eye = defaultPanoramaEye(state, places);
    }
    if (eye) resolved.eye = pictureSpace(*eye, exaggeration);
    if (view.lookAt) {
        auto target = places.resolve(*view.lookAt, "--look-at");
        if (!target) return target.error();
        resolved.lookAt = pictureSpace(*target, exaggeration);
    }
    return resolved;
}

}  // namespace terray
