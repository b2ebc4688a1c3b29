// SPDX-License-Identifier: Apache-2.0
// One cell of the drawn surface against one ray, in double precision: the quadratic and its first
// root.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "kernel/height.h"
#include "kernel/layout/layout.h"

namespace terray::exact {

/// A cell as the tracer sees it: its tile, its place (in cells of its mip, global) and four posts.
struct Cell {
    uint32_t slot = kNoSlot;
    int mip = 0;
    int64_t x = 0, y = 0;  ///< global, in cells of `mip`
    double h00 = 0, h10 = 0, h01 = 0, h11 = 0;
    bool valid = false;  ///< all four posts exist
};

inline Cell loadCell(const TerrainCut& cut, uint32_t slot, int64_t x, int64_t y) {
    const TileDesc& tile = cut.tiles[slot];
    Cell cell{slot, static_cast<int>(tile.mipFlags & kTileMipMask), x, y, 0, 0, 0, 0, false};
    const int i = static_cast<int>(x & 511), j = static_cast<int>(y & 511);
    cell.h00 = postHeight(cut, tile, i, j);
    cell.h10 = postHeight(cut, tile, i + 1, j);
    cell.h01 = postHeight(cut, tile, i, j + 1);
    cell.h11 = postHeight(cut, tile, i + 1, j + 1);
    cell.valid = std::isfinite(cell.h00 + cell.h10 + cell.h01 + cell.h11);
    return cell;
}

/// Ray coordinates in cells of a mip.
struct CellRay {
    double x, y, dx, dy;
};
inline CellRay cellRay(const Ray& ray, int mip) {
    const double s = 1.0 / static_cast<double>(1u << mip);
    return {ray.x * s, ray.y * s, ray.dx * s, ray.dy * s};
}

inline double rayHeight(const Ray& ray, double t) { return ray.z + t * (ray.dz + ray.bend * t); }

/// Bilinear height; exact at the edges (both cells of an edge get the same bits).
inline double bilinear(const Cell& c, double u, double v) {
    if (u == 0.0) return c.h00 + (c.h01 - c.h00) * v;
    if (u == 1.0) return c.h10 + (c.h11 - c.h10) * v;
    if (v == 0.0) return c.h00 + (c.h10 - c.h00) * u;
    if (v == 1.0) return c.h01 + (c.h11 - c.h01) * u;
    return (c.h00 + (c.h10 - c.h00) * u) +
           v * ((c.h01 - c.h00) + u * ((c.h11 - c.h01) - (c.h10 - c.h00)));
}

/// Height on the two triangles of a cell; at the edges exact, as bilinear.
inline double triangular(const Cell& c, double u, double v) {
    if (u == 0.0 || u == 1.0 || v == 0.0 || v == 1.0) return bilinear(c, u, v);
    if (u + v <= 1.0) return c.h00 + (c.h10 - c.h00) * u + (c.h01 - c.h00) * v;
    return c.h11 + (c.h01 - c.h11) * (1.0 - u) + (c.h10 - c.h11) * (1.0 - v);
}

/// Slope of one of a cell's two triangles along a ray, metres per t.
inline double triangleSlope(const Cell& c, const CellRay& r, bool upper) {
    return upper ? (c.h11 - c.h01) * r.dx + (c.h11 - c.h10) * r.dy
                 : (c.h10 - c.h00) * r.dx + (c.h01 - c.h00) * r.dy;
}

/// t at which a ray crosses the cell's diagonal u + v = 1; infinite if it runs along it.
inline double diagonalTime(const Cell& c, const CellRay& r) {
    const double across = r.dx + r.dy;
    const double ahead = (static_cast<double>(c.x) - r.x) + (static_cast<double>(c.y) - r.y) + 1.0;
    return across != 0.0 ? ahead / across : std::numeric_limits<double>::infinity();
}

/// f(t0 + s) = f0 + f1 s + f2 s^2: ray height less bilinear surface height along the ray.
struct Quadratic {
    double f0, f1, f2;
    double at(double s) const { return f0 + s * (f1 + s * f2); }
};
inline Quadratic cellQuadratic(const Cell& c, const Ray& ray, double t0, double u, double v) {
    const CellRay r = cellRay(ray, c.mip);
    const double b = c.h10 - c.h00, e = c.h01 - c.h00, d = (c.h11 - c.h01) - b;
    return {rayHeight(ray, t0) - bilinear(c, u, v),
            ray.dz + 2.0 * ray.bend * t0 - (b * r.dx + e * r.dy + d * (u * r.dy + v * r.dx)),
            ray.bend - d * r.dx * r.dy};
}

/// Smallest root of q in [0, length], given the (consistent) signs at both ends; nullopt if the
/// quadratic keeps its sign. A zero at an end is a root; so is a touch from one side.
inline std::optional<double> firstRoot(const Quadratic& q, double length, double fEnd) {
    if (q.f0 == 0.0) return 0.0;
    const bool crosses = (q.f0 > 0.0) != (fEnd > 0.0) || fEnd == 0.0;
    if (!crosses) {  // two roots inside, or none: decided at the extremum
        const double extremum = -q.f1 / (2.0 * q.f2);
        if (!(extremum > 0.0 && extremum < length)) return std::nullopt;
        const double value = q.at(extremum);
        if (value != 0.0 && (value > 0.0) == (q.f0 > 0.0)) return std::nullopt;
    }
    const double disc = std::sqrt(std::max(q.f1 * q.f1 - 4.0 * q.f2 * q.f0, 0.0));
    const double k = -0.5 * (q.f1 + std::copysign(disc, q.f1));
    const double r1 = k / q.f2, r2 = q.f0 / k;
    double best = std::numeric_limits<double>::infinity();
    const double slack = 1e-9 * length;
    if (r1 >= 0.0 && r1 <= length + slack) best = r1;
    if (r2 >= 0.0 && r2 <= length + slack) best = std::min(best, r2);
    if (!std::isfinite(best)) best = crosses ? length : -q.f1 / (2.0 * q.f2);
    return std::min(best, length);
}

}  // namespace terray::exact
