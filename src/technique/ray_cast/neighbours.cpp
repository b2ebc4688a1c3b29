// SPDX-License-Identifier: Apache-2.0
// Compares rays of a block's corners: all that is asked for is monotone over a picture rectangle.
#include "technique/ray_cast/neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/columns.h"

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

/// One pixel against a row below, where "below" is further down in the picture.
struct Step {
    double aside;   ///< columns to the right of the pixel below
    double rise;    ///< metres above the line through the row below
    double across;  ///< cells from ray to ray of that row
};
Step stepOf(const RayFrame& rays, double px, double py, int side, int rows) {
    const Place here = placeAhead(rays, px, py, side, 1.0);
    const Place a = placeAhead(rays, px, py + rows, side, 1.0);
    const Place b = placeAhead(rays, px + 1, py + rows, side, 1.0);
    const double x = b.x - a.x, y = b.y - a.y;
    Step step;
    step.aside = ((here.x - a.x) * x + (here.y - a.y) * y) / (x * x + y * y);
    step.rise = here.z - (a.z + step.aside * (b.z - a.z));
    step.across = std::fabs(x) + std::fabs(y);
    return step;
}

/// The greatest s (1 - s) of places between `from` and `to`, in columns, that stand at the share s
/// of the way between two columns.
double mostBetween(double from, double to, int first, int last) {
    constexpr double kSlack = 0.004;
    double most = 0;
    for (int column = first; column < last; ++column) {
        const double a = std::max(from - column - kSlack, 0.0);
        const double b = std::min(to - column + kSlack, 1.0);
        const double s = std::clamp(0.5, a, std::max(a, b));
        most = std::max(most, s * (1 - s));
    }
    return most;
}

}  // namespace

std::optional<Neighbours> neighboursOf(const RayFrame& rays, const PixelBlock& block, int side,
                                       int rows) {
    constexpr double kNone = 1e-7;  ///< columns: rounding
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    double from = kEndless, to = -kEndless, rise = kEndless, across = 0;
    int sign = 0;
    for (const double y : {block.y0 - rows, block.y1}) {
        for (const double x : {block.x0, block.x1}) {
            Step step = stepOf(rays, x, y, side, rows);
            if (!(std::fabs(step.rise) > 0)) return std::nullopt;
            const int up = step.rise > 0 ? 1 : -1;
            if (sign != 0 && up != sign) return std::nullopt;
            sign = up;
            if (up < 0) step.aside = -step.aside;  // the row "below" is the one further up
            from = std::min(from, step.aside);
            to = std::max(to, step.aside);
            rise = std::min(rise, std::fabs(step.rise));
            across = std::max(across, step.across);
        }
    }
    Neighbours n;
    n.upwards = sign > 0;
    n.rows = rows;
    if (std::max(-from, to) < kNone) {
        n.sharp.at = kEndless;
        return n;
    }
    if (!(std::max(-from, to) <= kMarchReach - 0.01)) return std::nullopt;
    if (std::fabs(from) < kNone) from = 0;
    if (std::fabs(to) < kNone) to = 0;
    from -= 1e-3 * std::fabs(from);
    to += 1e-3 * std::fabs(to);
    n.first = static_cast<int>(std::floor(from));
    n.last = static_cast<int>(std::ceil(to));
    // A ray at the share s of the way between two others: the ground rises from below the one to
    // above the ray and falls below the other, by rise (1 / s + 1 / (1 - s)) from slope to slope.
    n.sharp.at = 0.97 * rise / (mostBetween(from, to, n.first, n.last) * across);
    if (rays.camera().projection == Projection::Ortho)
        n.sharp.at = n.sharp.at / (1 + across);
    else
        n.sharp.perW = across * 1.03;
    return n;
}

double asideAt(const RayFrame& rays, double px, double py) {
    const double ahead = rays.columnTerms(px)[kTermForward] + rays.rowTerms(py)[kTermForward];
    const Step step = stepOf(rays, px, py, ahead < 0 ? -1 : 1, 1);
    const bool stands = std::fabs(step.rise) > 0 && std::isfinite(step.aside);
    return stands ? std::fabs(step.aside) : std::numeric_limits<double>::infinity();
}

}  // namespace terray
