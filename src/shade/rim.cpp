// SPDX-License-Identifier: Apache-2.0
// Marks the cells that are not outside, follows their borders, and straightens these after Douglas
// and Peucker 1973.
#include "shade/rim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

namespace terray {
namespace {

/// How far a straight side may be from the corners that it replaces, and by how much the rim is
/// within the ground, so that it stays there: cells of the overview.
int straightening(const Overview& view) {
    constexpr int kLarge = 1000;  // two cells of as many are hardly a pixel of a picture
    return std::max(view.width, view.height) > kLarge ? 2 : 1;
}

/// One byte a cell, with a ring of cells around that are outside.
struct CellMask {
    int width = 0, height = 0;  ///< ring included
    std::vector<uint8_t> cells;
    uint8_t& at(int i, int j) {
        return cells[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
    }
};

enum Cell : uint8_t { kHole = 0, kGround = 1, kOutside = 2 };

CellMask groundMask(const Overview& view) {
    CellMask mask{view.width + 1, view.height + 1, {}};
    mask.cells.assign(static_cast<size_t>(mask.width) * static_cast<size_t>(mask.height), kHole);
    const auto post = [&](int i, int j) {
        return view.heights[static_cast<size_t>(j) * static_cast<size_t>(view.width) +
                            static_cast<size_t>(i)];
    };
    for (int j = 0; j + 1 < view.height; ++j)
        for (int i = 0; i + 1 < view.width; ++i) {
            const float sum = post(i, j) + post(i + 1, j) + post(i, j + 1) + post(i + 1, j + 1);
            if (!std::isnan(sum)) mask.at(i + 1, j + 1) = kGround;
        }
    return mask;
}

/// Along a line of cells, `count` of them `step` apart: those within `reach` of a marked one are
/// marked.
void spread(const uint8_t* from, uint8_t* to, int count, ptrdiff_t step, int reach) {
    for (const bool backwards : {false, true}) {
        int left = 0;  // cells that are still within reach of the last marked one
        for (int n = 0; n < count; ++n) {
            const ptrdiff_t at = step * (backwards ? count - 1 - n : n);
            left = from[at] != 0 ? reach + 1 : left;
            if (left > 0) to[at] = 1;
            left -= left > 0 ? 1 : 0;
        }
    }
}

/// Marks what is within a square of `reach` cells around marked ones.
void spread(CellMask& mask, int reach) {
    for (const bool down : {false, true}) {
        const CellMask from = mask;
        const int lines = down ? mask.width : mask.height;
        for (int line = 0; line < lines; ++line) {
            const ptrdiff_t first = down ? line : static_cast<ptrdiff_t>(line) * mask.width;
            spread(from.cells.data() + first, mask.cells.data() + first,
                   down ? mask.height : mask.width, down ? mask.width : 1, reach);
        }
    }
}

void invert(CellMask& mask) {
    for (uint8_t& cell : mask.cells) cell = cell != 0 ? 0 : 1;
}

/// Holes too narrow for a square of 2 `reach` + 1 cells, beyond the raster or not, become ground:
/// voids that happen to reach the raster's border are no outside.
void closeNarrow(CellMask& mask, int reach) {
    CellMask wide{mask.width + 4 * reach, mask.height + 4 * reach, {}};
    wide.cells.assign(static_cast<size_t>(wide.width) * static_cast<size_t>(wide.height), 0);
    for (int j = 0; j < mask.height; ++j)
        for (int i = 0; i < mask.width; ++i) wide.at(i + 2 * reach, j + 2 * reach) = mask.at(i, j);
    spread(wide, reach);
    invert(wide);
    spread(wide, reach);
    for (int j = 1; j + 1 < mask.height; ++j)
        for (int i = 1; i + 1 < mask.width; ++i)
            if (wide.at(i + 2 * reach, j + 2 * reach) == 0) mask.at(i, j) = kGround;
}

/// Holes that are joined to the ring become outside.
void floodOutside(CellMask& mask) {
    std::vector<std::pair<int, int>> open{{0, 0}};
    mask.at(0, 0) = kOutside;
    while (!open.empty()) {
        const auto [i, j] = open.back();
        open.pop_back();
        const std::array<std::pair<int, int>, 4> beside{
            {{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}}};
        for (const auto& [x, y] : beside) {
            if (x < 0 || y < 0 || x >= mask.width || y >= mask.height) continue;
            if (mask.at(x, y) != kHole) continue;
            mask.at(x, y) = kOutside;
            open.emplace_back(x, y);
        }
    }
}

/// Nothing but the ring is outside.
bool isFull(const CellMask& mask) {
    const auto ring = 2 * static_cast<std::ptrdiff_t>(mask.width + mask.height - 2);
    return std::count(mask.cells.begin(), mask.cells.end(), kOutside) == ring;
}

/// Cells that touch an outside cell become outside, too.
CellMask shrunk(CellMask& mask) {
    CellMask less = mask;
    for (int j = 0; j < mask.height; ++j)
        for (int i = 0; i < mask.width; ++i) {
            if (mask.at(i, j) != kOutside) continue;
            for (int y = std::max(j - 1, 0); y <= std::min(j + 1, mask.height - 1); ++y)
                for (int x = std::max(i - 1, 0); x <= std::min(i + 1, mask.width - 1); ++x)
                    less.at(x, y) = kOutside;
        }
    return less;
}

/// Unit steps along cell borders: right, down, left, up; one bit each at the step's first corner.
constexpr std::array<int, 4> kStepI{1, 0, -1, 0}, kStepJ{0, 1, 0, -1};

CellMask borderSteps(CellMask& mask) {
    CellMask steps{mask.width + 1, mask.height + 1, {}};
    steps.cells.assign(static_cast<size_t>(steps.width) * static_cast<size_t>(steps.height), 0);
    const auto add = [&](int i, int j, int step) {
        steps.at(i, j) = static_cast<uint8_t>(steps.at(i, j) | (1 << step));
    };
    for (int j = 1; j + 1 < mask.height; ++j)
        for (int i = 1; i + 1 < mask.width; ++i) {
            if (mask.at(i, j) == kOutside) continue;
            if (mask.at(i, j - 1) == kOutside) add(i, j, 0);
            if (mask.at(i + 1, j) == kOutside) add(i + 1, j, 1);
            if (mask.at(i, j + 1) == kOutside) add(i + 1, j + 1, 2);
            if (mask.at(i - 1, j) == kOutside) add(i, j + 1, 3);
        }
    return steps;
}

/// Follows one border from a corner and takes its steps away; corners only where it turns.
std::vector<Vec2> followBorder(CellMask& steps, int i, int j) {
    std::vector<Vec2> corners;
    int step = 0;
    while ((steps.at(i, j) & (1 << step)) == 0) ++step;
    int last = -1;
    while (steps.at(i, j) & (1 << step)) {
        if (step != last) corners.emplace_back(i - 1, j - 1);  // less the ring
        last = step;
        steps.at(i, j) = static_cast<uint8_t>(steps.at(i, j) & ~(1 << step));
        i += kStepI[static_cast<size_t>(step)];
        j += kStepJ[static_cast<size_t>(step)];
        for (const int turn : {1, 0, 3}) {  // cells that touch at a corner only stay apart
            const int next = (last + turn) % 4;
            if ((steps.at(i, j) & (1 << next)) == 0) continue;
            step = next;
            break;
        }
    }
    return corners;
}

double distanceFrom(const Vec2& a, const Vec2& b, const Vec2& p) {
    const Vec2 along = b - a, to = p - a;
    const double length2 = glm::dot(along, along);
    const double share = length2 > 0 ? std::clamp(glm::dot(to, along) / length2, 0.0, 1.0) : 0.0;
    return glm::length(to - share * along);
}

/// Marks the corners to keep between two kept ones.
void straighten(std::span<const Vec2> corners, size_t first, size_t last, double reach,
                std::vector<bool>& keep) {
    std::vector<std::pair<size_t, size_t>> open{{first, last}};
    while (!open.empty()) {
        const auto [from, to] = open.back();
        open.pop_back();
        double most = reach;
        size_t farthest = from;
        for (size_t k = from + 1; k < to; ++k) {
            const double away = distanceFrom(corners[from], corners[to], corners[k]);
            if (away <= most) continue;
            most = away;
            farthest = k;
        }
        if (farthest == from) continue;
        keep[farthest] = true;
        open.emplace_back(from, farthest);
        open.emplace_back(farthest, to);
    }
}

RimLoop straightened(std::vector<Vec2> corners, double reach) {
    // Two corners that stand out are certain to be kept: the first of the upper left, and the one
    // farthest from it.
    const auto start =
        std::min_element(corners.begin(), corners.end(),
                         [](const Vec2& a, const Vec2& b) { return a.x + a.y < b.x + b.y; });
    std::rotate(corners.begin(), start, corners.end());
    corners.push_back(corners.front());
    size_t far = 1;
    for (size_t k = 1; k < corners.size(); ++k)
        if (glm::distance(corners[k], corners[0]) > glm::distance(corners[far], corners[0]))
            far = k;
    std::vector<bool> keep(corners.size(), false);
    keep.front() = keep[far] = true;
    straighten(corners, 0, far, reach, keep);
    straighten(corners, far, corners.size() - 1, reach, keep);
    RimLoop loop;
    for (size_t k = 0; k + 1 < corners.size(); ++k)
        if (keep[k]) loop.push_back(corners[k]);
    return loop;
}

}  // namespace

std::vector<RimLoop> outerRims(const Overview& view) {
    constexpr int kWideHole = 64;  // of the raster's smaller side
    CellMask mask = groundMask(view);
    if (const int close = std::min(view.width, view.height) / (2 * kWideHole); close > 0)
        closeNarrow(mask, close);
    floodOutside(mask);
    const int reach = straightening(view);
    if (!isFull(mask))
        for (int k = 0; k < reach; ++k) mask = shrunk(mask);
    CellMask steps = borderSteps(mask);
    const double size = std::ldexp(1.0, view.mip);
    std::vector<RimLoop> loops;
    for (int j = 0; j < steps.height; ++j)
        for (int i = 0; i < steps.width; ++i)
            while (steps.at(i, j) != 0) {
                RimLoop loop = straightened(followBorder(steps, i, j), reach);
                for (Vec2& corner : loop) corner *= size;
                if (loop.size() > 2) loops.push_back(std::move(loop));
            }
    return loops;
}

}  // namespace terray
