// SPDX-License-Identifier: Apache-2.0
// Cubic pieces through values at increasing knots, with continuous speed.
#pragma once

#include <cstddef>
#include <vector>

#include "math/types.h"

namespace terray {

/// Passes through its values exactly; constant beyond its ends. const-shared.
template <class V>
class Spline {
public:
    /// As many knots, strictly increasing, as values and slopes; at least one.
    Spline(std::vector<double> knots, std::vector<V> values, std::vector<V> slopes)
        : knots_(std::move(knots)), values_(std::move(values)), slopes_(std::move(slopes)) {}

    V at(double t) const;
    V slopeAt(double t) const;
    double begin() const { return knots_.front(); }
    double end() const { return knots_.back(); }

private:
    std::vector<double> knots_;
    std::vector<V> values_, slopes_;
};

/// Through places: slopes of the parabola through three neighbours, at most three times the
/// shorter neighbouring piece's own; a piece that rests stays at rest.
Spline<Vec3> smoothSpline(std::vector<double> knots, std::vector<Vec3> values);

/// Through numbers, never beyond the two that are joined (Fritsch and Butland 1984).
Spline<double> monotoneSpline(std::vector<double> knots, std::vector<double> values);

/// Index of the piece that holds t: the last knot not above it, but never the last one of all.
size_t pieceAt(const std::vector<double>& knots, double t);

}  // namespace terray
