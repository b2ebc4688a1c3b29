// SPDX-License-Identifier: Apache-2.0
// GeoFrame: maps between the data's coordinates, degrees and the world, over PROJ.
#include "geo/frame.h"

#include <cmath>
#include <optional>

#include "geo/proj_objects.h"

namespace terray {

struct GeoFrame::State {
    // the context must outlive the objects made in it: it is destroyed last
    proj::Context context;
    proj::Object workingFromData;            // null: the same CRS
    std::optional<proj::DegreeMap> degrees;  // of the data CRS; none: no (geodetic) CRS
    double metresPerUnit = 1;
    double dataLongitudesPerTurn = 0;  // data units of a full turn if the data are geographic
    double dataCentreLongitude = 0;
    bool wrapsLongitudes = false;
    proj::Ellipsoid ellipsoid;
};

namespace {

Error outsideProjection(const char* what, Vec2 p) {
    return makeError(ErrorCode::Input,
                     "the {} {:.10g}, {:.10g} cannot be mapped: it lies outside the projection's "
                     "domain",
                     what, p.x, p.y);
}

Error noCrs() {
    return makeError(ErrorCode::Usage,
                     "the data have no coordinate reference system, so longitudes and latitudes "
                     "cannot be used; give --assign-crs EPSG:n");
}

bool isFinite(Vec2 p) { return std::isfinite(p.x) && std::isfinite(p.y); }

Result<proj::Object> makeTransform(PJ_CONTEXT* context, const PJ* from, const PJ* to) {
    const proj::Object raw(proj_create_crs_to_crs_from_pj(context, from, to, nullptr, nullptr));
    proj::Object normal(raw ? proj_normalize_for_visualization(context, raw.get()) : nullptr);
    if (!normal) {
        return makeError(ErrorCode::Input,
                         "PROJ knows no way from the CRS '{}' to '{}'; choose another one with "
                         "--crs or --assign-crs",
                         proj_get_name(from), proj_get_name(to));
    }
    return normal;
}

Result<proj::Object> parseHorizontal(PJ_CONTEXT* context, const std::string& definition) {
    const Result<proj::Object> parsed = proj::parseCrs(context, definition);
    if (!parsed) return parsed.error();
    proj::Object part = proj::horizontalPart(context, parsed->get());
    if (!part) {
        return makeError(ErrorCode::Input,
                         "the coordinate reference system '{}' has no horizontal coordinates",
                         proj_get_name(parsed->get()));
    }
    return part;
}

}  // namespace

GeoFrame::GeoFrame(std::unique_ptr<State> state) : state_(std::move(state)) {}
GeoFrame::GeoFrame(GeoFrame&&) noexcept = default;
GeoFrame& GeoFrame::operator=(GeoFrame&&) noexcept = default;
GeoFrame::~GeoFrame() = default;

Result<GeoFrame> GeoFrame::make(const std::string& dataCrs, const std::string& workingCrs) {
    auto state = std::make_unique<State>();
    const std::string& workingText = workingCrs.empty() ? dataCrs : workingCrs;
    const std::string& dataText = dataCrs.empty() ? workingCrs : dataCrs;
    if (workingText.empty()) return GeoFrame(std::move(state));

    state->context = proj::makeContext();
    PJ_CONTEXT* context = state->context.get();
    const Result<proj::Object> working = parseHorizontal(context, workingText);
    if (!working) return working.error();
    const Result<proj::Object> data = parseHorizontal(context, dataText);
    if (!data) return data.error();

    const proj::Object inner = proj::unbound(context, working->get());
    state->metresPerUnit = proj::axisUnit(context, inner.get(), 0).factor;
    if (proj::isGeographic(inner.get())) {
        return makeError(ErrorCode::Usage,
                         "the working CRS '{}' is in degrees; give a projected one",
                         proj_get_name(inner.get()));
    }
    if (!proj_is_equivalent_to_with_ctx(context, data->get(), working->get(),
                                        PJ_COMP_EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS)) {
        Result<proj::Object> transform = makeTransform(context, data->get(), working->get());
        if (!transform) return transform.error();
        state->workingFromData = std::move(*transform);
    }
    const proj::Object dataInner = proj::unbound(context, data->get());
    if (proj::isGeographic(dataInner.get())) {
        state->dataLongitudesPerTurn = 2 * kPi / proj::axisUnit(context, dataInner.get(), 0).factor;
    }
    if (proj::isProjected(inner.get())) {
        Result<proj::DegreeMap> degrees = proj::DegreeMap::make(context, data->get());
        if (!degrees) return degrees.error();
        state->degrees = std::move(*degrees);
        state->ellipsoid = proj::ellipsoidOf(context, inner.get());
    }
    return GeoFrame(std::move(state));
}

bool GeoFrame::hasCrs() const { return state_->degrees.has_value(); }

bool GeoFrame::isSameCrs() const { return !state_->workingFromData; }

void GeoFrame::wrapDataLongitudes(double centre) {
    state_->dataCentreLongitude = centre;
    state_->wrapsLongitudes = state_->dataLongitudesPerTurn > 0;
}

Result<Vec2> GeoFrame::worldFromData(Vec2 p) const {
    if (!state_->workingFromData) return p * state_->metresPerUnit;
    const PJ_COORD c =
        proj_trans(state_->workingFromData.get(), PJ_FWD, proj_coord(p.x, p.y, 0, 0));
    const Vec2 world{c.xy.x * state_->metresPerUnit, c.xy.y * state_->metresPerUnit};
    if (!isFinite(world)) return outsideProjection("place", p);
    return world;
}

Result<Vec2> GeoFrame::dataFromWorld(Vec2 p) const {
    const Vec2 crs = p / state_->metresPerUnit;
    if (!state_->workingFromData) return crs;
    const PJ_COORD c =
        proj_trans(state_->workingFromData.get(), PJ_INV, proj_coord(crs.x, crs.y, 0, 0));
    Vec2 data{c.xy.x, c.xy.y};
    if (!isFinite(data)) return outsideProjection("working CRS place", crs);
    if (state_->wrapsLongitudes) {
        const double turn = state_->dataLongitudesPerTurn;
        data.x -= turn * std::round((data.x - state_->dataCentreLongitude) / turn);
    }
    return data;
}

Result<Vec2> GeoFrame::worldFromLonLat(Vec2 lonLatDeg) const {
    if (!hasCrs()) return noCrs();
    const Vec2 data = state_->degrees->crsFromLonLat(lonLatDeg);
    if (!isFinite(data)) return outsideProjection("longitude and latitude", lonLatDeg);
    return worldFromData(data);
}

Result<Vec2> GeoFrame::lonLatFromWorld(Vec2 p) const {
    if (!hasCrs()) return noCrs();
    const Result<Vec2> data = dataFromWorld(p);
    if (!data) return data.error();
    Vec2 lonLat = state_->degrees->lonLatFromCrs(*data);
    if (!isFinite(lonLat)) return outsideProjection("place", *data);
    lonLat.x -= 360 * std::round(lonLat.x / 360);
    return lonLat;
}

Result<double> GeoFrame::meridianConvergence(Vec2 world) const {
    const Result<Vec2> place = lonLatFromWorld(world);
    if (!place) return place.error();
    // central difference along the meridian, about 2 x 11 m; one-sided at the poles
    constexpr double kStepDeg = 1e-4;
    const double south = std::max(place->y - kStepDeg, -90.0);
    const double north = std::min(place->y + kStepDeg, 90.0);
    const Result<Vec2> below = worldFromLonLat({place->x, south});
    if (!below) return below.error();
    const Result<Vec2> above = worldFromLonLat({place->x, north});
    if (!above) return above.error();
    const Vec2 trueNorth = *above - *below;
    return -std::atan2(trueNorth.x, trueNorth.y);
}

double GeoFrame::curvatureRadius(Vec2 world) const {
    const Result<Vec2> place = lonLatFromWorld(world);
    if (!place) return 0;
    const double a = state_->ellipsoid.semiMajor, b = state_->ellipsoid.semiMinor;
    const double sine = std::sin(radFromDeg(place->y));
    const double eccentricity2 = 1 - (b * b) / (a * a);
    return b / (1 - eccentricity2 * sine * sine);  // sqrt(M N)
}

}  // namespace terray
