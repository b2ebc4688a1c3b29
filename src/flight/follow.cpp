// SPDX-License-Identifier: Apache-2.0
// Following the ground.
#include "flight/follow.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "flight/smooth.h"

namespace terray {
namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();

/// Highest ground of a straight piece, looked at a cell apart.
double highestBetween(Vec2 from, Vec2 to, const Ground& ground, double spacing) {
    constexpr double kMostSteps = 64;
    const double steps = std::clamp(std::ceil(glm::length(to - from) / spacing), 1.0, kMostSteps);
    double highest = kNone;
    for (double k = 0; k <= steps; ++k)
        highest = std::max(highest, ground(glm::mix(from, to, k / steps)).value_or(kNone));
    return highest;
}

/// Heights between the ends of each gap; the nearest one before the first and after the last.
void bridgeGaps(std::vector<double>& heights) {
    const size_t n = heights.size();
    size_t last = n;  // of those known
    for (size_t k = 0; k < n; ++k) {
        if (heights[k] == kNone) continue;
        for (size_t gap = last == n ? 0 : last + 1; gap < k; ++gap) {
            const double share =
                last == n ? 1 : static_cast<double>(gap - last) / static_cast<double>(k - last);
            heights[gap] = std::lerp(last == n ? heights[k] : heights[last], heights[k], share);
        }
        last = k;
    }
    for (size_t gap = last + 1; last < n && gap < n; ++gap) heights[gap] = heights[last];
}

}  // namespace

Moments momentsOf(double begin, double end) {
    constexpr double kStep = 0.1, kLeast = 16, kMost = 500'000;
    const double pieces = std::clamp(std::ceil((end - begin) / kStep), kLeast, kMost);
    return {begin, (end - begin) / pieces, static_cast<size_t>(pieces) + 1};
}

std::vector<double> groundAlong(const std::vector<Vec2>& places, const Ground& ground,
                                double spacing) {
    const size_t n = places.size();
    std::vector<double> heights(n);
    for (size_t k = 0; k < n; ++k) {
        const Vec2 from = glm::mix(places[k > 0 ? k - 1 : 0], places[k], 0.5);
        const Vec2 to = glm::mix(places[k], places[std::min(k + 1, n - 1)], 0.5);
        heights[k] = std::max(highestBetween(from, places[k], ground, spacing),
                              highestBetween(places[k], to, ground, spacing));
    }
    if (std::all_of(heights.begin(), heights.end(), [](double z) { return z == kNone; })) return {};
    bridgeGaps(heights);
    return heights;
}

std::vector<double> smoothLift(const std::vector<double>& lack, size_t reach) {
    return smoothed(windowMaximum(lack, reach), reach, Beyond::Mirrored);
}

std::vector<double> followedHeights(const std::vector<double>& ground, double height,
                                    size_t reach) {
    std::vector<double> heights = smoothed(ground, reach, Beyond::Mirrored);
    std::vector<double> lack(ground.size());
    for (size_t k = 0; k < ground.size(); ++k) {
        heights[k] += height;
        lack[k] = std::max(0.0, ground[k] + 0.5 * height - heights[k]);
    }
    const std::vector<double> lift = smoothLift(lack, reach);
    for (size_t k = 0; k < heights.size(); ++k) heights[k] += lift[k];
    return heights;
}

}  // namespace terray
