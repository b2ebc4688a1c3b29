// SPDX-License-Identifier: Apache-2.0
// Owning handles over PROJ's C API, and the questions about a CRS that this room asks more than
// once. Internal to geo: the only header that includes PROJ.
#pragma once

#include <proj.h>

#include <memory>
#include <string>

#include "base/result.h"
#include "math/types.h"

namespace terray::proj {

struct ContextDeleter {
    void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};
struct ObjectDeleter {
    void operator()(PJ* object) const { proj_destroy(object); }
};
using Context = std::unique_ptr<PJ_CONTEXT, ContextDeleter>;
using Object = std::unique_ptr<PJ, ObjectDeleter>;

/// A context without network access that prints nothing. confined.
Context makeContext();

/// A CRS from WKT, PROJJSON, a PROJ string, a whole name or "EPSG:n". Text that a person typed is a
/// Usage error when it is wrong; WKT and PROJJSON (from a file) are an Input error.
Result<Object> parseCrs(PJ_CONTEXT* context, const std::string& definition);

/// The 2-D horizontal part: of a compound CRS its first member, of a 3-D one without the height.
/// A bound CRS (one with its own shift to WGS 84) stays bound. Null if there is none.
Object horizontalPart(PJ_CONTEXT* context, const PJ* crs);
/// The CRS itself, without a shift to WGS 84 that is tied to it.
Object unbound(PJ_CONTEXT* context, const PJ* crs);
/// The 2-D geographic CRS below a (bound, projected or geographic) CRS; null if there is none.
Object geographicBase(PJ_CONTEXT* context, const PJ* crs);

bool isGeographic(const PJ* crs);
bool isProjected(const PJ* crs);
std::string wkt2(PJ_CONTEXT* context, const PJ* object);

/// A unit of a coordinate system's axis: radians or metres per unit.
struct AxisUnit {
    std::string name, direction;
    double factor = 1;
};
/// Axis `index` of an unbound single CRS; factor 1 and no name if it has no such axis.
AxisUnit axisUnit(PJ_CONTEXT* context, const PJ* crs, int index);
int axisCount(PJ_CONTEXT* context, const PJ* crs);

struct Ellipsoid {
    double semiMajor = 0, semiMinor = 0;  ///< metres
};
Ellipsoid ellipsoidOf(PJ_CONTEXT* context, const PJ* crs);

/// Coordinates of a CRS (x first) to degrees of longitude from Greenwich and latitude on its own
/// datum, and back. confined.
class DegreeMap {
public:
    static Result<DegreeMap> make(PJ_CONTEXT* context, const PJ* horizontalCrs);
    /// HUGE_VAL twice where the projection is not defined.
    Vec2 lonLatFromCrs(Vec2 p) const;
    Vec2 crsFromLonLat(Vec2 lonLatDeg) const;

private:
    Object toGeographic_;  // null: the CRS is geographic
    double degPerUnit_ = 1;
    double primeMeridianDeg_ = 0;
};

}  // namespace terray::proj
