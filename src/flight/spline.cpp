// SPDX-License-Identifier: Apache-2.0
// Slopes and evaluation of cubic Hermite splines.
#include "flight/spline.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"

namespace terray {
namespace {

double length(const Vec3& v) { return glm::length(v); }

/// No longer than `most`.
Vec3 capped(const Vec3& slope, double most) {
    const double is = length(slope);
    return is > most ? slope * (most / is) : slope;
}

template <class V>
std::vector<V> pieceSlopes(const std::vector<double>& knots, const std::vector<V>& values) {
    std::vector<V> slopes;
    for (size_t k = 0; k + 1 < knots.size(); ++k)
        slopes.push_back((values[k + 1] - values[k]) / (knots[k + 1] - knots[k]));
    return slopes;
}

/// Slope at an end of the data whose first pieces have the slopes a (nearest) and b.
double endSlope(double h0, double h1, double a, double b) {
    const double slope = ((2 * h0 + h1) * a - h0 * b) / (h0 + h1);
    if (slope * a <= 0) return 0;
    if (a * b <= 0 && std::abs(slope) > 3 * std::abs(a)) return 3 * a;
    return slope;
}

}  // namespace

size_t pieceAt(const std::vector<double>& knots, double t) {
    if (knots.size() < 2) return 0;
    const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, t);
    return static_cast<size_t>(above - knots.begin()) - 1;
}

template <class V>
V Spline<V>::at(double t) const {
    if (t <= begin()) return values_.front();
    if (t >= end()) return values_.back();
    const size_t k = pieceAt(knots_, t);
    const double h = knots_[k + 1] - knots_[k];
    const double u = (t - knots_[k]) / h;
    const double w = 1 - u;
    // From the value on: what rests stays to the bit.
    return values_[k] + (values_[k + 1] - values_[k]) * (u * u * (3 - 2 * u)) +
           slopes_[k] * (h * u * w * w) - slopes_[k + 1] * (h * u * u * w);
}

template <class V>
V Spline<V>::slopeAt(double t) const {
    if (t < begin() || t > end() || knots_.size() < 2) return V(0.0);
    const size_t k = pieceAt(knots_, t);
    const double h = knots_[k + 1] - knots_[k];
    const double u = (t - knots_[k]) / h;
    return (values_[k + 1] - values_[k]) * (6 * u * (1 - u) / h) +
           slopes_[k] * ((1 - u) * (1 - 3 * u)) + slopes_[k + 1] * (u * (3 * u - 2));
}

template class Spline<double>;
template class Spline<Vec3>;

Spline<Vec3> smoothSpline(std::vector<double> knots, std::vector<Vec3> values) {
    TERRAY_ASSERT(!knots.empty() && knots.size() == values.size());
    const size_t n = knots.size();
    std::vector<Vec3> slopes(n, Vec3{0.0});
    if (n >= 2) {
        const std::vector<Vec3> pieces = pieceSlopes(knots, values);
        for (size_t k = 1; k + 1 < n; ++k) {
            const double before = knots[k] - knots[k - 1], after = knots[k + 1] - knots[k];
            const Vec3 slope = (after * pieces[k - 1] + before * pieces[k]) / (before + after);
            slopes[k] = capped(slope, 3 * std::min(length(pieces[k - 1]), length(pieces[k])));
        }
        const auto end = [&](const Vec3& piece, const Vec3& other) {
            return n == 2 ? piece : capped(1.5 * piece - 0.5 * other, 3 * length(piece));
        };
        slopes.front() = end(pieces.front(), slopes[1]);
        slopes.back() = end(pieces.back(), slopes[n - 2]);
    }
    return {std::move(knots), std::move(values), std::move(slopes)};
}

Spline<double> monotoneSpline(std::vector<double> knots, std::vector<double> values) {
    TERRAY_ASSERT(!knots.empty() && knots.size() == values.size());
    const size_t n = knots.size();
    std::vector<double> slopes(n, 0.0);
    if (n >= 2) {
        const std::vector<double> pieces = pieceSlopes(knots, values);
        for (size_t k = 1; k + 1 < n; ++k) {
            if (pieces[k - 1] * pieces[k] <= 0) continue;
            const double before = knots[k] - knots[k - 1], after = knots[k + 1] - knots[k];
            const double a = before + 2 * after, b = 2 * before + after;
            slopes[k] = (a + b) / (a / pieces[k - 1] + b / pieces[k]);
        }
        if (n == 2) {
            slopes = {pieces[0], pieces[0]};
        } else {
            const auto width = [&](size_t k) { return knots[k + 1] - knots[k]; };
            slopes.front() = endSlope(width(0), width(1), pieces[0], pieces[1]);
            slopes.back() = endSlope(width(n - 2), width(n - 3), pieces[n - 2], pieces[n - 3]);
        }
    }
    return {std::move(knots), std::move(values), std::move(slopes)};
}

}  // namespace terray
