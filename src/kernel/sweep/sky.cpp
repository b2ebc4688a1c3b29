// SPDX-License-Identifier: Apache-2.0
// Sky light by line sweeps: along every direction the posts fall into disjoint lines that pass
// exactly through them; on each line the upper convex hull of the posts behind gives the horizon
// in O(1) amortised a post.
#include "kernel/sweep/sky.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/assert.h"

namespace terray {
namespace {

constexpr double kTurn = 6.283185307179586;

/// A step from post to post; both ways along it are swept. Weights: share of all azimuths.
struct Direction {
    int di = 0, dj = 0;
    float length = 1;  ///< metres a step
    float weight = 0;  ///< of each of the two ways; over all directions they sum to 1/2
};

/// Coprime steps of at most `reach` posts within half a turn: 2, 4, 8, 16 ... of them.
std::vector<Direction> stepsWithin(int reach) {
    std::vector<Direction> steps;
    for (int dj = 0; dj <= reach; ++dj) {
        for (int di = -reach; di <= reach; ++di) {
            if (std::gcd(di, dj) != 1 || (dj == 0 && di < 0)) continue;
            steps.push_back({di, dj, 1, 0});
        }
    }
    return steps;
}

/// At least `azimuths` directions (both ways counted), each with the share of azimuths nearest it.
std::vector<Direction> directionsFor(int azimuths, double stepX, double stepY) {
    std::vector<Direction> steps;
    if (azimuths <= 4) {
        steps = {{1, 0, 1, 0}, {0, 1, 1, 0}};
    } else {
        for (int reach = 1; static_cast<int>(steps.size()) * 2 < azimuths; ++reach)
            steps = stepsWithin(reach);
    }
    const auto angle = [&](const Direction& d) { return std::atan2(d.dj * stepY, d.di * stepX); };
    std::sort(steps.begin(), steps.end(),
              [&](const Direction& a, const Direction& b) { return angle(a) < angle(b); });
    const size_t n = steps.size();
    for (size_t k = 0; k < n; ++k) {
        const double before = k > 0 ? angle(steps[k - 1]) : angle(steps[n - 1]) - kTurn / 2;
        const double after = k + 1 < n ? angle(steps[k + 1]) : angle(steps[0]) + kTurn / 2;
        steps[k].weight = static_cast<float>((after - before) / (2 * kTurn));
        steps[k].length = static_cast<float>(std::hypot(steps[k].di * stepX, steps[k].dj * stepY));
    }
    return steps;
}

/// A hull post: place along the line and height, metres.
struct HullPost {
    float s, z;
};

/// One line: `count` posts from `first`, `step` elements apart.
struct Line {
    int64_t first, step;
    int count;
};

/// Adds the open share of the sky behind each post of a line, walking it one way.
void sweepLine(const float* heights, float* visible, const Line& line, const Direction& direction,
               std::vector<HullPost>& hull) {
    if (hull.size() < static_cast<size_t>(line.count) + 1)
        hull.resize(static_cast<size_t>(line.count) + 1);
    int top = -1;  // of the upper hull of all posts behind, as seen when walking
    int64_t at = line.first;
    for (int k = 0; k < line.count; ++k, at += line.step) {
        const float z = heights[at];
        if (std::isnan(z)) continue;
        const float s = static_cast<float>(k) * direction.length;
        while (top >= 1) {
            const HullPost &a = hull[static_cast<size_t>(top)],
                           &b = hull[static_cast<size_t>(top - 1)];
            if ((b.z - z) * (s - a.s) < (a.z - z) * (s - b.s)) break;
            --top;
        }
        float open = direction.weight;
        if (top >= 0) {
            const HullPost& horizon = hull[static_cast<size_t>(top)];
            const float rise = horizon.z - z, run = s - horizon.s;
            if (rise > 0) open *= run * run / (run * run + rise * rise);
        }
        visible[at] += open;
        hull[static_cast<size_t>(++top)] = {s, z};
    }
}

/// First posts of the lines of a direction: those whose predecessor lies outside the grid.
std::vector<Line> linesAlong(const SkyGrid& grid, const Direction& d) {
    std::vector<Line> lines;
    const int w = grid.width, h = grid.height;
    const auto add = [&](int i, int j) {
        const int acrossSteps = d.di > 0 ? (w - 1 - i) / d.di : d.di < 0 ? i / -d.di : w + h;
        const int downSteps = d.dj > 0 ? (h - 1 - j) / d.dj : w + h;
        lines.push_back({static_cast<int64_t>(j) * w + i, static_cast<int64_t>(d.dj) * w + d.di,
                         std::min(acrossSteps, downSteps) + 1});
    };
    for (int j = 0; j < h; ++j) {
        if (j < d.dj) {
            for (int i = 0; i < w; ++i) add(i, j);
        } else if (d.di > 0) {
            for (int i = 0; i < std::min(d.di, w); ++i) add(i, j);
        } else {
            for (int i = std::max(0, w + d.di); i < w; ++i) add(i, j);
        }
    }
    return lines;
}

void sweepDirection(const SkyGrid& grid, const Direction& direction, float* visible) {
    const std::vector<Line> lines = linesAlong(grid, direction);
    // The lines of one direction are disjoint, and every post adds up its directions in the same
    // order: the sums do not depend on threads.
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<size_t>(0, lines.size(), 32),
                              [&](const auto& range) {
                                  thread_local std::vector<HullPost> hull;
                                  for (size_t k = range.begin(); k != range.end(); ++k) {
                                      const Line& there = lines[k];
                                      const Line back{there.first + there.step * (there.count - 1),
                                                      -there.step, there.count};
                                      sweepLine(grid.heights, visible, there, direction, hull);
                                      sweepLine(grid.heights, visible, back, direction, hull);
                                  }
                              });
}

}  // namespace

void computeSkyVisibility(const SkyGrid& grid, int azimuths, std::span<float> visible) {
    TERRAY_ASSERT(grid.width >= 1 && grid.height >= 1);
    TERRAY_ASSERT(visible.size() ==
                  static_cast<size_t>(grid.width) * static_cast<size_t>(grid.height));
    std::fill(visible.begin(), visible.end(), 0.0f);
    for (const Direction& direction : directionsFor(azimuths, grid.stepX, grid.stepY))
        sweepDirection(grid, direction, visible.data());
    for (size_t k = 0; k < visible.size(); ++k)
        if (std::isnan(grid.heights[k])) visible[k] = 1.0f;
}

}  // namespace terray
