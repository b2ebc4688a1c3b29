// SPDX-License-Identifier: Apache-2.0
// Compares rays of a block's corners: all that is asked for is monotone over a picture rectangle.
#include "technique/ray_cast/neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terray {
namespace {

/// Where a ray is, `ahead` metres ahead, from the eye (ortho: from the lattice's origin).
struct Place {
    double x, y, z;
};
Place placeAhead(const RayFrame& rays, double px, double py, int side, double ahead) {
    const RayTerms column = rays.columnTerms(px), row = rays.rowTerms(py);
    const auto term = [&](RayTerm k) { return column[k] + row[k]; };
    const double w = (ahead - side * term(kTermForward0)) / (side * term(kTermForward));
    const bool ortho = rays.camera().projection == Projection::Ortho;
    return {(ortho ? term(kTermX) : 0.0) + w * term(kTermDx),
            (ortho ? term(kTermY) : 0.0) + w * term(kTermDy),
            (ortho ? term(kTermZ) : 0.0) + w * term(kTermDz)};
}

/// One pixel against the row below, where "below" is further down in the picture.
struct Step {
    double aside;   ///< columns to the right of the pixel below
    double rise;    ///< metres above the line through the row below
    double across;  ///< cells from ray to ray of that row
};
Step stepOf(const RayFrame& rays, double px, double py, int side) {
    const Place here = placeAhead(rays, px, py, side, 1.0);
    const Place a = placeAhead(rays, px, py + 1, side, 1.0);
    const Place b = placeAhead(rays, px + 1, py + 1, side, 1.0);
    const double x = b.x - a.x, y = b.y - a.y;
    Step step;
    step.aside = ((here.x - a.x) * x + (here.y - a.y) * y) / (x * x + y * y);
    step.rise = here.z - (a.z + step.aside * (b.z - a.z));
    step.across = std::fabs(x) + std::fabs(y);
    return step;
}

}  // namespace

std::optional<Neighbours> neighboursOf(const RayFrame& rays, const PixelBlock& block, int side) {
    constexpr double kNone = 1e-7;  ///< columns: rounding
    double left = 0, right = 0, rise = std::numeric_limits<double>::infinity(), across = 0;
    int sign = 0;
    for (const double y : {block.y0 - 1, block.y1}) {
        for (const double x : {block.x0, block.x1}) {
            Step step = stepOf(rays, x, y, side);
            if (!(std::fabs(step.rise) > 0)) return std::nullopt;
            const int up = step.rise > 0 ? 1 : -1;
            if (sign != 0 && up != sign) return std::nullopt;
            sign = up;
            if (up < 0) step.aside = -step.aside;  // the row "below" is the one further up
            left = std::max(left, -step.aside);
            right = std::max(right, step.aside);
            rise = std::min(rise, std::fabs(step.rise));
            across = std::max(across, step.across);
        }
    }
    Neighbours n;
    n.upwards = sign > 0;
    if (std::max(left, right) < kNone) {
        n.sharp.at = std::numeric_limits<double>::infinity();
        return n;
    }
    if (!(std::max(left, right) <= kMarchReach - 0.01)) return std::nullopt;
    n.left = left < kNone ? 0 : static_cast<int>(std::ceil(left * 1.001));
    n.right = right < kNone ? 0 : static_cast<int>(std::ceil(right * 1.001));
    // A ray at the share s of the way between two others: the ground rises from below the one to
    // above the ray and falls below the other, by rise (1 / s + 1 / (1 - s)) from slope to slope.
    const double most = std::max(left, right) * 1.01;
    const double share = most < 0.5 ? most : 0.5;
    n.sharp.at = 0.97 * rise / (share * (1 - share) * across);
    if (rays.camera().projection == Projection::Ortho)
        n.sharp.at = n.sharp.at / (1 + across);
    else
        n.sharp.perW = across * 1.03;
    return n;
}

}  // namespace terray
