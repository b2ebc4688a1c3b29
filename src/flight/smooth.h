// SPDX-License-Identifier: Apache-2.0
// Smoothing of evenly spaced values.
#pragma once

#include <cstddef>
#include <vector>

namespace terray {

/// What stands beyond the ends of the values.
enum class Beyond {
    Mirrored,   ///< the values again: means stay within what they are means of
    Continued,  ///< the values turned about the end: the ends keep their values
};

/// Three moving means in turn: a smooth bell that reaches `reach` values to either side (rounded
/// to whole thirds).
std::vector<double> smoothed(const std::vector<double>& values, size_t reach, Beyond beyond);

/// For each value the largest among its neighbours up to `reach` away.
std::vector<double> windowMaximum(const std::vector<double>& values, size_t reach);

}  // namespace terray
