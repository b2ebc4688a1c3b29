// SPDX-License-Identifier: Apache-2.0
// Parsing and taking apart CRS objects with PROJ.
#include "geo/proj_objects.h"

#include <proj_experimental.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

namespace terray::proj {
namespace {

/// The start of a definition, fit for a one-line message.
std::string shortened(const std::string& definition) {
    constexpr size_t kLength = 60;
    std::string text = definition.substr(0, kLength);
    for (char& c : text) {
        if (static_cast<unsigned char>(c) < 0x20) c = ' ';
    }
    return definition.size() > kLength ? text + "..." : text;
}

bool isTyped(const std::string& definition) {
    return definition.find_first_of("[{") == std::string::npos;
}

bool sameName(const char* a, const std::string& b) {
    const auto lower = [](unsigned char c) { return std::tolower(c); };
    return std::ranges::equal(std::string_view(a ? a : ""), b, {}, lower, lower);
}

/// PROJ completes a bare name to whatever CRS resembles it ("foo" becomes Amersfoort).
bool isGuess(const PJ* crs, const std::string& definition) {
    const bool isName = definition.find_first_of("[{:=") == std::string::npos;
    return isName && !sameName(proj_get_name(crs), definition);
}

Object clone(PJ_CONTEXT* context, const PJ* object) { return Object(proj_clone(context, object)); }

bool is3D(PJ_CONTEXT* context, const PJ* crs) {
    return proj_get_type(crs) == PJ_TYPE_GEOGRAPHIC_3D_CRS || axisCount(context, crs) == 3;
}

}  // namespace

Context makeContext() {
    Context context(proj_context_create());
    proj_log_level(context.get(), PJ_LOG_NONE);
    proj_context_set_enable_network(context.get(), 0);
    return context;
}

Result<Object> parseCrs(PJ_CONTEXT* context, const std::string& definition) {
    const bool projString = definition.find("+proj=") != std::string::npos ||
                            definition.find("+init=") != std::string::npos;
    const bool needsType = projString && definition.find("type=crs") == std::string::npos;
    const std::string text = needsType ? definition + " +type=crs" : definition;
    Object crs(proj_create(context, text.c_str()));
    if (crs && proj_is_crs(crs.get()) && !isGuess(crs.get(), definition)) return crs;
    if (isTyped(definition)) {
        return makeError(ErrorCode::Usage,
                         "'{}' is not a coordinate reference system that PROJ knows; give EPSG:n, "
                         "for example EPSG:32633, or WKT",
                         shortened(definition));
    }
    return makeError(ErrorCode::Input,
                     "the coordinate reference system '{}' cannot be understood; give the right "
                     "one with --assign-crs EPSG:n",
                     shortened(definition));
}

Object unbound(PJ_CONTEXT* context, const PJ* crs) {
    if (proj_get_type(crs) == PJ_TYPE_BOUND_CRS) return Object(proj_get_source_crs(context, crs));
    return clone(context, crs);
}

Object horizontalPart(PJ_CONTEXT* context, const PJ* crs) {
    Object part = clone(context, crs);
    while (part && proj_get_type(part.get()) == PJ_TYPE_COMPOUND_CRS) {
        part = Object(proj_crs_get_sub_crs(context, part.get(), 0));
    }
    if (!part) return nullptr;
    const Object inner = unbound(context, part.get());
    if (!inner) return nullptr;
    switch (proj_get_type(inner.get())) {
        case PJ_TYPE_VERTICAL_CRS:
        case PJ_TYPE_GEOCENTRIC_CRS:
        case PJ_TYPE_TEMPORAL_CRS: return nullptr;
        case PJ_TYPE_COMPOUND_CRS: return horizontalPart(context, inner.get());
        default: break;
    }
    if (is3D(context, inner.get())) {
        return Object(proj_crs_demote_to_2D(context, nullptr, inner.get()));
    }
    return part;
}

Object geographicBase(PJ_CONTEXT* context, const PJ* crs) {
    const Object inner = unbound(context, crs);
    if (!inner || (!isGeographic(inner.get()) && !isProjected(inner.get()))) return nullptr;
    Object base(proj_crs_get_geodetic_crs(context, inner.get()));
    if (!base || proj_get_type(base.get()) == PJ_TYPE_GEOGRAPHIC_2D_CRS) return base;
    return Object(proj_crs_demote_to_2D(context, nullptr, base.get()));
}

bool isGeographic(const PJ* crs) {
    const PJ_TYPE type = proj_get_type(crs);
    return type == PJ_TYPE_GEOGRAPHIC_2D_CRS || type == PJ_TYPE_GEOGRAPHIC_3D_CRS;
}

bool isProjected(const PJ* crs) { return proj_get_type(crs) == PJ_TYPE_PROJECTED_CRS; }

std::string wkt2(PJ_CONTEXT* context, const PJ* object) {
    const char* const options[] = {"MULTILINE=NO", nullptr};
    const char* text = proj_as_wkt(context, object, PJ_WKT2_2019, options);
    return text ? text : "";
}

AxisUnit axisUnit(PJ_CONTEXT* context, const PJ* crs, int index) {
    AxisUnit unit;
    const Object system(proj_crs_get_coordinate_system(context, crs));
    if (!system) return unit;
    const char* name = nullptr;
    const char* direction = nullptr;
    if (proj_cs_get_axis_info(context, system.get(), index, nullptr, nullptr, &direction,
                              &unit.factor, &name, nullptr, nullptr)) {
        unit.name = name ? name : "";
        unit.direction = direction ? direction : "";
    }
    return unit;
}

int axisCount(PJ_CONTEXT* context, const PJ* crs) {
    const Object system(proj_crs_get_coordinate_system(context, crs));
    return system ? proj_cs_get_axis_count(context, system.get()) : 0;
}

Ellipsoid ellipsoidOf(PJ_CONTEXT* context, const PJ* crs) {
    Ellipsoid result;
    const Object ellipsoid(proj_get_ellipsoid(context, crs));
    if (ellipsoid) {
        proj_ellipsoid_get_parameters(context, ellipsoid.get(), &result.semiMajor,
                                      &result.semiMinor, nullptr, nullptr);
    }
    return result;
}

Result<DegreeMap> DegreeMap::make(PJ_CONTEXT* context, const PJ* horizontalCrs) {
    DegreeMap map;
    const Object inner = unbound(context, horizontalCrs);
    const Object base = geographicBase(context, horizontalCrs);
    if (!base) {
        return makeError(ErrorCode::Input, "the CRS '{}' has no longitudes and latitudes",
                         proj_get_name(horizontalCrs));
    }
    map.degPerUnit_ = degFromRad(axisUnit(context, base.get(), 0).factor);
    const Object meridian(proj_get_prime_meridian(context, base.get()));
    double longitude = 0, factor = 0;
    if (meridian &&
        proj_prime_meridian_get_parameters(context, meridian.get(), &longitude, &factor, nullptr)) {
        map.primeMeridianDeg_ = degFromRad(longitude * factor);
    }
    if (isGeographic(inner.get())) return map;
    const Object raw(
        proj_create_crs_to_crs_from_pj(context, inner.get(), base.get(), nullptr, nullptr));
    if (raw) map.toGeographic_ = Object(proj_normalize_for_visualization(context, raw.get()));
    if (!map.toGeographic_) {
        return makeError(ErrorCode::Input,
                         "the CRS '{}' uses a projection that PROJ cannot compute",
                         proj_get_name(horizontalCrs));
    }
    return map;
}

Vec2 DegreeMap::lonLatFromCrs(Vec2 p) const {
    PJ_COORD c = proj_coord(p.x, p.y, 0, 0);
    if (toGeographic_) c = proj_trans(toGeographic_.get(), PJ_FWD, c);
    if (!std::isfinite(c.xy.x) || !std::isfinite(c.xy.y)) return {HUGE_VAL, HUGE_VAL};
    return {c.xy.x * degPerUnit_ + primeMeridianDeg_, c.xy.y * degPerUnit_};
}

Vec2 DegreeMap::crsFromLonLat(Vec2 lonLatDeg) const {
    PJ_COORD c = proj_coord((lonLatDeg.x - primeMeridianDeg_) / degPerUnit_,
                            lonLatDeg.y / degPerUnit_, 0, 0);
    if (toGeographic_) c = proj_trans(toGeographic_.get(), PJ_INV, c);
    if (!std::isfinite(c.xy.x) || !std::isfinite(c.xy.y)) return {HUGE_VAL, HUGE_VAL};
    return {c.xy.x, c.xy.y};
}

}  // namespace terray::proj
