// SPDX-License-Identifier: Apache-2.0
// Points and vectors over glm. World: metres, x east, y north (of the working CRS), z up.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace terray {

using Vec2 = glm::dvec2;  ///< any 2-D direction or difference
using Vec3 = glm::dvec3;  ///< any 3-D direction or difference, metres

/// A place in the working CRS: metres east, north, and height above the vertical datum.
struct WorldPoint {
    double x = 0, y = 0, z = 0;
    Vec3 vec() const { return {x, y, z}; }
    static WorldPoint fromVec(const Vec3& v) { return {v.x, v.y, v.z}; }
};
inline Vec3 operator-(const WorldPoint& a, const WorldPoint& b) { return a.vec() - b.vec(); }
inline WorldPoint operator+(const WorldPoint& p, const Vec3& v) {
    return WorldPoint::fromVec(p.vec() + v);
}

/// A place on the post lattice of mip 0: column (to the right) and row (downwards); post (i, j) is
/// at exactly (i, j).
struct LatticePoint {
    double i = 0, j = 0;
};

constexpr double kPi = 3.14159265358979323846;
constexpr double radFromDeg(double deg) { return deg * (kPi / 180.0); }
constexpr double degFromRad(double rad) { return rad * (180.0 / kPi); }

}  // namespace terray
