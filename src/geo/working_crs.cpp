// SPDX-License-Identifier: Apache-2.0
// chooseWorkingCrs: keeps a CRS whose scale is true to 0.1 %, else picks UTM, LAEA or a polar one.
#include <proj_experimental.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "geo/frame.h"
#include "geo/proj_objects.h"

namespace terray {
namespace {

constexpr double kMaxScaleError = 1e-3;
constexpr double kMaxUtmWidthDeg = 6;
constexpr double kMaxWidthDeg = 40;
constexpr double kUtmMaxLatitude = 84;
constexpr int kGrid = 21;  // places a side at which the extent is looked at

/// An extent in degrees on the source's datum; longitudes run on, so that west <= east.
struct DegreeExtent {
    double west = 0, east = 0, south = 0, north = 0;
    double maxScaleError = 0;  ///< largest |scale - 1| of the source's projection
    double worstLatitude = 0;  ///< where it is
    Vec2 centre() const { return {(west + east) / 2, (south + north) / 2}; }
    double width() const { return east - west; }
    double height() const { return north - south; }
    double farthestLatitude() const { return std::max(std::abs(south), std::abs(north)); }
    double nearestLatitude() const {
        return south * north <= 0 ? 0 : std::min(std::abs(south), std::abs(north));
    }
};

Vec2 gridPlace(const Vec2& lo, const Vec2& hi, int i, int j) {
    return lo + (hi - lo) * Vec2(i, j) / double(kGrid - 1);
}

Error outsideDomain(const CrsFacts& source) {
    return makeError(ErrorCode::Input,
                     "part of the extent lies outside the domain of the CRS '{}'; cut a window "
                     "(gdal_translate -projwin) or give the right CRS with --assign-crs",
                     source.name);
}

/// Measures how true lengths are in a projected CRS against its ellipsoid. (PROJ's proj_factors()
/// is not used: in 9.1 it is wrong for CRSs in feet and takes milliseconds a place.)
class ScaleMeter {
public:
    ScaleMeter(const proj::DegreeMap& map, const CrsFacts& facts) : map_(map), facts_(facts) {}

    /// Largest |scale - 1| in any direction (Tissot's semi-axes); infinite where undefined.
    double errorAt(Vec2 lonLatDeg) const {
        const double sine = std::sin(radFromDeg(lonLatDeg.y));
        const double a = facts_.semiMajor, b = facts_.semiMinor;
        const double w2 = 1 - (1 - b * b / (a * a)) * sine * sine;
        const double normal = a / std::sqrt(w2), meridional = b * b / (a * w2 * std::sqrt(w2));
        const double parallel = normal * std::cos(radFromDeg(lonLatDeg.y));
        const Vec2 east = derivative(lonLatDeg, {1, 0}) / parallel;
        const Vec2 north = derivative(lonLatDeg, {0, 1}) / meridional;
        const double sum = glm::dot(east, east) + glm::dot(north, north);
        const double area = east.x * north.y - east.y * north.x;
        const double root = std::sqrt(std::max(0.0, sum * sum - 4 * area * area));
        const double longest = std::sqrt((sum + root) / 2);
        const double shortest = std::sqrt(std::max(0.0, (sum - root) / 2));
        const double error = std::max(std::abs(longest - 1), std::abs(shortest - 1));
        return std::isfinite(error) ? error : HUGE_VAL;
    }

private:
    /// Metres per radian along an axis of the graticule: the shorter of both one-sided
    /// differences, because one of them may jump over a map's seam.
    Vec2 derivative(Vec2 lonLatDeg, Vec2 axis) const {
        constexpr double kStepRad = 1e-6;
        const Vec2 step = axis * degFromRad(kStepRad);
        const Vec2 here = map_.crsFromLonLat(lonLatDeg);
        const Vec2 after = map_.crsFromLonLat(lonLatDeg + step) - here;
        const Vec2 before = here - map_.crsFromLonLat(lonLatDeg - step);
        const bool useAfter = !(glm::dot(before, before) < glm::dot(after, after));
        return (useAfter ? after : before) * (facts_.metresPerUnit / kStepRad);
    }

    const proj::DegreeMap& map_;
    const CrsFacts& facts_;
};

/// Degrees over a grid of the extent, and how true the scale is there.
Result<DegreeExtent> degreeExtent(PJ_CONTEXT* context, const CrsFacts& source, PJ* horizontal,
                                  const Vec2& lo, const Vec2& hi) {
    const Result<proj::DegreeMap> map = proj::DegreeMap::make(context, horizontal);
    if (!map) return map.error();
    const ScaleMeter meter(*map, source);
    const double centreLon = map->lonLatFromCrs((lo + hi) / 2.0).x;
    if (!std::isfinite(centreLon)) return outsideDomain(source);
    DegreeExtent extent{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, 0, 0};
    for (int j = 0; j < kGrid; ++j) {
        for (int i = 0; i < kGrid; ++i) {
            Vec2 place = map->lonLatFromCrs(gridPlace(lo, hi, i, j));
            if (!std::isfinite(place.x)) return outsideDomain(source);
            if (!source.geographic) {
                place.x = centreLon + std::remainder(place.x - centreLon, 360);
                constexpr double kNearPole = 89.999;
                const double error =
                    meter.errorAt({place.x, std::clamp(place.y, -kNearPole, kNearPole)});
                if (error > extent.maxScaleError) {
                    extent.maxScaleError = error;
                    extent.worstLatitude = place.y;
                }
            }
            extent.west = std::min(extent.west, place.x);
            extent.east = std::max(extent.east, place.x);
            extent.south = std::min(extent.south, place.y);
            extent.north = std::max(extent.north, place.y);
        }
    }
    return extent;
}

/// Geographic coordinates that cannot be degrees are refused; half a pixel beyond a pole is not.
Result<void> checkDegrees(const CrsFacts& source, const DegreeExtent& extent) {
    constexpr double kSlackDeg = 1;
    if (extent.farthestLatitude() <= 90 + kSlackDeg && extent.west >= -360 - kSlackDeg &&
        extent.east <= 540 + kSlackDeg) {
        return {};
    }
    return makeError(ErrorCode::Input,
                     "the extent (longitude {:.6g} to {:.6g}, latitude {:.6g} to {:.6g}) is not "
                     "in degrees, as the CRS '{}' asks; give the right CRS with --assign-crs",
                     extent.west, extent.east, extent.south, extent.north, source.name);
}

Vec2 wrapped(Vec2 lonLatDeg) {
    double lon = std::remainder(lonLatDeg.x, 360);
    if (lon >= 180) lon -= 360;
    return {lon, lonLatDeg.y};
}

/// A projection of our own: its PROJ conversion and what it is called.
struct Projection {
    proj::Object conversion;
    std::string name;
};

Projection makeUtm(PJ_CONTEXT* context, const Vec2& centre, bool isEarth) {
    const bool north = centre.y >= 0;
    if (isEarth) {
        const int zone = std::clamp(static_cast<int>(std::floor((centre.x + 180) / 6)) + 1, 1, 60);
        return {proj::Object(proj_create_conversion_utm(context, zone, north)),
                fmt::format("UTM zone {}{}", zone, north ? 'N' : 'S')};
    }
    return {
        proj::Object(proj_create_conversion_transverse_mercator(
            context, 0, centre.x, 0.9996, 500000, north ? 0 : 10000000, nullptr, 0, nullptr, 0)),
        fmt::format("Transverse Mercator {:.6g}", centre.x)};
}

Projection makePolar(PJ_CONTEXT* context, bool north, double longitude) {
    return {proj::Object(proj_create_conversion_polar_stereographic_variant_a(
                context, north ? 90 : -90, longitude, 0.994, 0, 0, nullptr, 0, nullptr, 0)),
            fmt::format("Polar Stereographic {} {:.6g}", north ? "North" : "South", longitude)};
}

Projection makeLaea(PJ_CONTEXT* context, const Vec2& centre) {
    return {proj::Object(proj_create_conversion_lambert_azimuthal_equal_area(
                context, centre.y, centre.x, 0, 0, nullptr, 0, nullptr, 0)),
            fmt::format("LAEA {:.6g} {:.6g}", centre.y, centre.x)};
}

/// Which projection an extent gets by the rule of frame.h; no conversion: too large for any.
Projection chooseProjection(PJ_CONTEXT* context, const DegreeExtent& extent, bool isEarth) {
    const Vec2 centre = wrapped(extent.centre());
    const bool reachesPole = extent.farthestLatitude() > kUtmMaxLatitude;
    const bool isCap = extent.nearestLatitude() >= 90 - kMaxWidthDeg / 2;
    if (isCap && (reachesPole || extent.width() > kMaxWidthDeg)) {
        return makePolar(context, extent.south > 0, extent.width() <= 180 ? centre.x : 0);
    }
    if (extent.height() > kMaxWidthDeg || extent.width() > kMaxWidthDeg) return {};
    if (extent.width() <= kMaxUtmWidthDeg && !reachesPole) {
        return makeUtm(context, centre, isEarth);
    }
    return makeLaea(context, centre);
}

/// The projected CRS over the source's own datum; takes over a shift to WGS 84 that is tied to it.
proj::Object projectedOn(PJ_CONTEXT* context, const PJ* horizontal, const PJ* base,
                         const Projection& projection) {
    const std::string name = fmt::format("{} / {}", proj_get_name(base), projection.name);
    const proj::Object system(
        proj_create_cartesian_2D_cs(context, PJ_CART2D_EASTING_NORTHING, nullptr, 0));
    proj::Object crs(proj_create_projected_crs(context, name.c_str(), base,
                                               projection.conversion.get(), system.get()));
    if (!crs || proj_get_type(horizontal) != PJ_TYPE_BOUND_CRS) return crs;
    const proj::Object hub(proj_get_target_crs(context, horizontal));
    const proj::Object shift(proj_crs_get_coordoperation(context, horizontal));
    return proj::Object(proj_crs_create_bound_crs(context, crs.get(), hub.get(), shift.get()));
}

/// The same CRS as the EPSG registry has it (with its code), if it does.
std::string registeredWkt(PJ_CONTEXT* context, const PJ* crs) {
    const PJ_TYPE type = PJ_TYPE_PROJECTED_CRS;
    PJ_OBJ_LIST* list =
        proj_create_from_name(context, "EPSG", proj_get_name(crs), &type, 1, 0, 1, nullptr);
    std::string wkt;
    if (list && proj_list_get_count(list) > 0) {
        const proj::Object found(proj_list_get(context, list, 0));
        if (found &&
            proj_is_equivalent_to_with_ctx(context, found.get(), crs, PJ_COMP_EQUIVALENT)) {
            wkt = proj::wkt2(context, found.get());
        }
    }
    proj_list_destroy(list);
    return wkt.empty() ? proj::wkt2(context, crs) : wkt;
}

Result<WorkingCrs> forcedCrs(PJ_CONTEXT* context, const CrsFacts& source, const PJ* horizontal,
                             const std::string& forced) {
    const Result<proj::Object> parsed = proj::parseCrs(context, forced);
    if (!parsed) {
        return makeError(ErrorCode::Usage, "--crs: {}", parsed.error().message);
    }
    const proj::Object part = proj::horizontalPart(context, parsed->get());
    const proj::Object inner = part ? proj::unbound(context, part.get()) : proj::Object();
    if (!inner || !proj::isProjected(inner.get())) {
        return makeError(ErrorCode::Usage,
                         "--crs {}: '{}' is not a projected CRS; give one in metres or feet, for "
                         "example EPSG:32633",
                         forced, proj_get_name(parsed->get()));
    }
    WorkingCrs working;
    working.wkt = proj::wkt2(context, part.get());
    working.name = proj_get_name(inner.get());
    working.same = proj_is_equivalent_to_with_ctx(context, part.get(), horizontal,
                                                  PJ_COMP_EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS);
    if (!working.same) {
        working.reason =
            fmt::format("warped from {} to {}, as --crs asks", source.name, working.name);
    }
    return working;
}

/// Axes that point west make a mirrored picture; such a CRS is never worked in.
bool hasWestwardAxis(PJ_CONTEXT* context, const PJ* crs) {
    return proj::axisUnit(context, crs, 0).direction == "west" ||
           proj::axisUnit(context, crs, 1).direction == "west";
}

std::string reasonToWarp(const CrsFacts& source, const DegreeExtent& extent,
                         const std::string& workingName) {
    if (source.geographic) {
        return fmt::format("coordinates are degrees ({}): warped to {}", source.name, workingName);
    }
    if (extent.maxScaleError <= kMaxScaleError) {
        return fmt::format("the axes of {} point west: warped to {}", source.name, workingName);
    }
    return fmt::format("the scale of {} is off by {:.2g} % at latitude {:.2f}: warped to {}",
                       source.name, 100 * extent.maxScaleError, extent.worstLatitude, workingName);
}

}  // namespace

Result<WorkingCrs> chooseWorkingCrs(const CrsFacts& source, const Vec2& extentMin,
                                    const Vec2& extentMax, const std::string& forced) {
    const proj::Context owner = proj::makeContext();
    PJ_CONTEXT* context = owner.get();
    const Result<proj::Object> parsed = proj::parseCrs(context, source.wkt);
    if (!parsed) return parsed.error();
    const proj::Object horizontal = proj::horizontalPart(context, parsed->get());
    if (!horizontal) return outsideDomain(source);
    if (!forced.empty()) return forcedCrs(context, source, horizontal.get(), forced);

    WorkingCrs same{proj::wkt2(context, horizontal.get()), source.name, true, ""};
    const proj::Object base = proj::geographicBase(context, horizontal.get());
    if (!base) return same;  // a local CRS: plain coordinates
    const Result<DegreeExtent> extent =
        degreeExtent(context, source, horizontal.get(), extentMin, extentMax);
    if (!extent) return extent.error();
    TERRAY_TRY(checkDegrees(source, *extent));
    const proj::Object inner = proj::unbound(context, horizontal.get());
    if (source.projected && extent->maxScaleError <= kMaxScaleError &&
        !hasWestwardAxis(context, inner.get())) {
        return same;
    }

    const double radius = source.semiMajor;
    const bool isEarth = radius > 6.3e6 && radius < 6.45e6;
    const Projection projection = chooseProjection(context, *extent, isEarth);
    if (!projection.conversion) {
        return makeError(ErrorCode::Input,
                         "the extent is {:.4g} x {:.4g} degrees, more than the {:.0f} that one "
                         "plane can show; cut a window (gdal_translate -projwin) or choose a "
                         "projection with --crs",
                         extent->width(), extent->height(), kMaxWidthDeg);
    }
    const proj::Object crs = projectedOn(context, horizontal.get(), base.get(), projection);
    if (!crs) return outsideDomain(source);
    const proj::Object plain = proj::unbound(context, crs.get());
    WorkingCrs working;
    working.same = false;
    working.name = proj_get_name(plain.get());
    working.wkt = registeredWkt(context, crs.get());
    working.reason = reasonToWarp(source, *extent, working.name);
    return working;
}

}  // namespace terray
