// SPDX-License-Identifier: Apache-2.0
// The sun of a frame.
#include "engine/sunlight.h"

#include <cmath>

#include "base/log.h"
#include "geo/sun.h"

namespace terray {
namespace {

constexpr double kDefaultElevationDeg = 40;

std::string lonLatText(Vec2 p) {
    return fmt::format("{:.3f} {}, {:.3f} {}", std::abs(p.y), p.y < 0 ? 'S' : 'N', std::abs(p.x),
                       p.x < 0 ? 'W' : 'E');
}

Result<SunPosition> sunAtTime(const GeoFrame& frame, Vec2 seen, const std::string& time) {
    auto moment = parseIsoTime(time);
    if (!moment) return moment.error();
    if (!frame.hasCrs())
        return makeError(ErrorCode::Usage,
                         "--time: without a CRS nobody knows where on earth this is; name it with "
                         "--assign-crs EPSG:n or give --sun AZ,EL");
    auto place = frame.lonLatFromWorld(seen);
    if (!place) return place.error();
    const SunPosition sun = sunPosition(moment->julianDay, place->x, place->y);
    log::note("sun at {} ({}) seen from {}: azimuth {:.1f}, elevation {:.1f} degrees{}",
              moment->utcText, moment->hadOffset ? "UTC" : "no offset given: taken as UTC",
              lonLatText(*place), sun.azimuthDeg, sun.elevationDeg,
              sun.elevationDeg <= 0 ? "; it is below the horizon: no sunlight and no shadows" : "");
    return sun;
}

}  // namespace

double defaultSunAzimuthDeg(const Camera& camera) {
    if (camera.projection == Projection::Panorama) return 315;
    const Vec3 ahead = std::abs(camera.forward.z) > 0.999 ? camera.up : camera.forward;
    const double heading = degFromRad(std::atan2(ahead.x, ahead.y));  // -180..180
    return heading > 100 || heading < -170 ? 45 : 315;
}

std::array<double, 2> defaultSunAzElDeg(double azimuthDeg) {
    return {azimuthDeg, kDefaultElevationDeg};
}

Result<std::array<double, 2>> sunAzElDegAt(const GeoFrame& frame, Vec2 seen,
                                           const std::string& time) {
    auto position = sunAtTime(frame, seen, time);
    if (!position) return position.error();
    return std::array{position->azimuthDeg, position->elevationDeg};
}

Result<Sun> computeSun(const Terrain::State& state, const GeoFrame& frame, const Camera& camera,
                       Vec2 seen, const RenderOptions& options) {
    SunPosition position{defaultSunAzimuthDeg(camera), kDefaultElevationDeg};
    if (options.sunAzElDeg) {
        position = {(*options.sunAzElDeg)[0], (*options.sunAzElDeg)[1]};
        if (position.elevationDeg <= 0)
            log::note("--sun: the sun is below the horizon: no sunlight and no shadows");
    } else if (!options.time.empty()) {
        auto atTime = sunAtTime(frame, seen, options.time);
        if (!atTime) return atTime.error();
        position = *atTime;
    }
    double convergence = 0;
    Sun sun;
    sun.centre = state.worldCentre();
    if (frame.hasCrs()) {
        auto angle = frame.meridianConvergence(sun.centre);
        if (!angle) return angle.error();
        convergence = *angle;
    }
    const double heading = radFromDeg(position.azimuthDeg) - convergence;
    const double elevation = radFromDeg(position.elevationDeg);
    sun.towards = {std::sin(heading) * std::cos(elevation), std::cos(heading) * std::cos(elevation),
                   std::sin(elevation)};
    sun.belowHorizon = position.elevationDeg <= 0;
    return sun;
}

}  // namespace terray
