// SPDX-License-Identifier: Apache-2.0
// Coordinate systems over PROJ: which working CRS to use, and maps between data, degrees and world.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "math/types.h"

namespace terray {

/// Facts about a CRS given as WKT, PROJJSON or "EPSG:n".
struct CrsFacts {
    std::string name, wkt;  ///< WKT2
    bool geographic = false, projected = false, vertical = false;
    double metresPerUnit = 1;             ///< horizontal linear unit (projected)
    std::string unitName;                 ///< "degree", "metre", "US survey foot", ...
    double semiMajor = 0, semiMinor = 0;  ///< metres
    std::string heightUnitName;  ///< of a compound or 3-D CRS's vertical axis; empty if none
    double metresPerHeightUnit = 1;
};
Result<CrsFacts> describeCrs(const std::string& definition);

/// The working CRS for a source (product page): projected with a point scale within 0.1 % over the
/// extent: itself. Otherwise UTM up to 6 degrees of width, LAEA up to 40; more is refused (Input).
/// The extent is in the source CRS. `forced` (--crs) overrides.
struct WorkingCrs {
    std::string wkt, name;
    bool same = true;    ///< the source CRS itself: no warp
    std::string reason;  ///< one sentence for the output when it is not
};
Result<WorkingCrs> chooseWorkingCrs(const CrsFacts& source, const Vec2& extentMin,
                                    const Vec2& extentMax, const std::string& forced);

/// Maps between a data CRS, degrees on its datum, and world metres in the working CRS. World =
/// working CRS coordinates * metresPerUnit. confined (PROJ contexts are per object; make one per
/// thread). Without any CRS all maps but degrees are the identity. Degrees: longitude (-180..180)
/// and latitude.
class GeoFrame {
public:
    static Result<GeoFrame> make(const std::string& dataCrs, const std::string& workingCrs);
    GeoFrame(GeoFrame&&) noexcept;
    GeoFrame& operator=(GeoFrame&&) noexcept;
    ~GeoFrame();

    bool hasCrs() const;
    /// The data's CRS is the working CRS (equivalent, whatever its name): maps only change units.
    bool isSameCrs() const;
    /// Geographic data may count longitudes 0..360 or beyond 180: dataFromWorld() then answers with
    /// the longitude (data units) that is nearest to `centre`, the middle of the data's extent.
    void wrapDataLongitudes(double centre);
    Result<Vec2> worldFromData(Vec2 p) const;
    Result<Vec2> dataFromWorld(Vec2 p) const;
    Result<Vec2> worldFromLonLat(Vec2 lonLatDeg) const;
    Result<Vec2> lonLatFromWorld(Vec2 p) const;
    /// Angle from true north to grid north at a place, radians, positive clockwise: azimuth from
    /// true north = heading from grid north + convergence.
    Result<double> meridianConvergence(Vec2 world) const;
    /// Gaussian mean radius of curvature of the ellipsoid at a place, metres; 0 without a CRS.
    double curvatureRadius(Vec2 world) const;

private:
    struct State;
    explicit GeoFrame(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace terray
