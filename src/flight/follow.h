// SPDX-License-Identifier: Apache-2.0
// Heights above the ground that do not bounce and never come too low.
#pragma once

#include <vector>

#include "flight/path.h"

namespace terray {

/// Evenly spaced moments of a flight, for what must be looked at along the whole of it.
struct Moments {
    double begin = 0, step = 1;
    size_t count = 2;

    double at(size_t k) const { return begin + step * static_cast<double>(k); }
    /// Values within so many seconds.
    size_t reach(double seconds) const { return static_cast<size_t>(seconds / step); }
};
/// About ten a second, and at most half a million.
Moments momentsOf(double begin, double end);

/// Highest ground on the way from halfway to the last place to halfway to the next one; gaps are
/// bridged from their ends. Empty if there is no ground at all.
std::vector<double> groundAlong(const std::vector<Vec2>& places, const Ground& ground,
                                double spacing);

/// The ground smoothed over `reach` values, plus `height`, lifted where that comes nearer than
/// half of it. The lift is a mean, over the same reach, of the largest lack within that reach, so
/// it is nowhere less than what is lacking.
std::vector<double> followedHeights(const std::vector<double>& ground, double height, size_t reach);

/// A smooth addition that makes up for every lack.
std::vector<double> smoothLift(const std::vector<double>& lack, size_t reach);

}  // namespace terray
