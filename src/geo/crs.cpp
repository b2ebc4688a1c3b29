// SPDX-License-Identifier: Apache-2.0
// describeCrs: the facts about a CRS that the rest of the program asks for.
#include "geo/frame.h"
#include "geo/proj_objects.h"

namespace terray {
namespace {

/// Fills the height unit from a vertical member of a compound CRS or a third axis.
void describeHeights(PJ_CONTEXT* context, const PJ* crs, CrsFacts& facts) {
    const proj::Object inner = proj::unbound(context, crs);
    if (!inner) return;
    if (proj_get_type(inner.get()) == PJ_TYPE_COMPOUND_CRS) {
        for (int i = 0; i < 2; ++i) {
            const proj::Object part(proj_crs_get_sub_crs(context, inner.get(), i));
            if (part) describeHeights(context, part.get(), facts);
        }
        return;
    }
    const bool isVertical = proj_get_type(inner.get()) == PJ_TYPE_VERTICAL_CRS;
    const int axis = isVertical ? 0 : 2;
    if (proj::axisCount(context, inner.get()) <= axis) return;
    const proj::AxisUnit unit = proj::axisUnit(context, inner.get(), axis);
    facts.vertical = true;
    facts.heightUnitName = unit.name;
    facts.metresPerHeightUnit = unit.factor;
}

}  // namespace

Result<CrsFacts> describeCrs(const std::string& definition) {
    const proj::Context context = proj::makeContext();
    const Result<proj::Object> parsed = proj::parseCrs(context.get(), definition);
    if (!parsed) return parsed.error();
    const PJ* crs = parsed->get();
    CrsFacts facts;
    facts.name = proj_get_name(crs);
    const proj::Object horizontal = proj::horizontalPart(context.get(), crs);
    const proj::Object inner =
        horizontal ? proj::unbound(context.get(), horizontal.get()) : proj::Object();
    if (!inner) {
        return makeError(ErrorCode::Input,
                         "the coordinate reference system '{}' has no horizontal coordinates; a "
                         "geographic or projected one is needed (--assign-crs EPSG:n)",
                         facts.name);
    }
    if (proj_get_type(crs) == PJ_TYPE_BOUND_CRS) facts.name = proj_get_name(inner.get());
    facts.wkt = proj::wkt2(context.get(), crs);
    facts.geographic = proj::isGeographic(inner.get());
    facts.projected = proj::isProjected(inner.get());
    const proj::AxisUnit unit = proj::axisUnit(context.get(), inner.get(), 0);
    facts.unitName = unit.name;
    if (!facts.geographic) facts.metresPerUnit = unit.factor;
    const proj::Ellipsoid ellipsoid = proj::ellipsoidOf(context.get(), inner.get());
    facts.semiMajor = ellipsoid.semiMajor;
    facts.semiMinor = ellipsoid.semiMinor;
    describeHeights(context.get(), crs, facts);
    if (facts.wkt.empty() || !(facts.metresPerUnit > 0)) {
        return makeError(ErrorCode::Input,
                         "the coordinate reference system '{}' is incomplete; give the right one "
                         "with --assign-crs EPSG:n",
                         facts.name);
    }
    return facts;
}

}  // namespace terray
