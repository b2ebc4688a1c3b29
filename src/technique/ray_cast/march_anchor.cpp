// SPDX-License-Identifier: Apache-2.0
// Anchors groups of a chunk's columns near where their rays are expected to hit: float errors grow
// from there.
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/simd/block.h"
#include "technique/ray_cast/marcher.h"

namespace terray {
namespace {

/// Bounds of |parts| of a group.
struct Reach {
    RayTerms column{};
    std::array<float, kTermCount> row{}, leastRow{};
    float operator()(RayTerm k) const { return columnOf(k) + row[k]; }
    float columnOf(RayTerm k) const { return static_cast<float>(1.001 * column[k]); }
};

void addRow(const float* parts, Reach& reach) {
    for (size_t k = 0; k < kTermCount; ++k) {
        const float part = std::fabs(parts[k]);
        reach.row[k] = part > reach.row[k] ? part : reach.row[k];
        reach.leastRow[k] = part < reach.leastRow[k] ? part : reach.leastRow[k];
    }
}

MarchErrors errorsOf(const TerrainCut& cut, const MarchGroup& group, const Reach& reach) {
    using simd::kFloatError;
    const float turned = 2.0f * group.bend * std::fabs(group.w0) * reach(kTermLength2);
    const float highest = std::max(std::fabs(cut.minZ), std::fabs(cut.maxZ));
    MarchErrors e;
    // A decoded post is rounded to half an ulp; here it is not.
    e.rounding = 0x1.2p-24f * highest;
    e.height0 = kFloatError * (reach(kTermZ) + turned * std::fabs(group.w0)) + e.rounding;
    e.height1 = 2.0f * kFloatError * (reach(kTermDz) + turned);
    e.shift0 = kFloatError * (1.0f + reach(kTermX) + reach(kTermY));
    e.shift1 = kFloatError * (reach(kTermDx) + reach(kTermDy));
    return e;
}

/// Any ray moves on by at least so many cells of mip 0 per w, in x or in y.
float leastSpeed(const Reach& reach) {
    const auto least = [&](RayTerm k) { return reach.leastRow[k] - reach.columnOf(k); };
    return std::max(least(kTermDx), least(kTermDy));
}

}  // namespace

/// The columns of a run as arrays, and how far those of a group lie apart at most.
void Marcher::tellColumns() {
    spread_.fill(0);
    for (size_t c = 0; c < kMarchColumns; ++c) {
        const RayTerms& middle =
            columns_[c / kMarchGroupColumns * kMarchGroupColumns + kMarchGroupColumns / 2];
        for (size_t k = 0; k < kTermCount; ++k) {
            columnTerms_[k][c] = columns_[c][k];
            spread_[k] = std::max(spread_[k], std::fabs(columns_[c][k] - middle[k]));
        }
    }
}

void Marcher::placeGroups(int first, int rows) {
    const float none = std::numeric_limits<float>::infinity();
    const float nearest = nearestKnown(0, tile_.width, none);
    for (int begin = 0; begin < tile_.width; begin += kGroupColumns) {
        const int end = std::min(begin + kGroupColumns, tile_.width);
        placeGroup(begin, end, first, rows, nearestKnown(begin, end, nearest));
    }
    anchorLanes(cut_, groups_.data(), lanes_);
}

/// The least that is known of the columns [begin, end) of the last row.
float Marcher::nearestKnown(int begin, int end, float otherwise) {
    float nearest = std::numeric_limits<float>::infinity();
    for (int c = begin; c < end; ++c) {
        const float below = known(1)[c];
        if (below >= 0) nearest = std::min(nearest, below);
    }
    return std::isfinite(nearest) ? nearest : otherwise;
}

void Marcher::placeGroup(int begin, int end, int first, int rows, float nearest) {
    MarchGroup& group = groups_[static_cast<size_t>(begin / kGroupColumns)];
    const RayTerms& middle = columns_[static_cast<size_t>(begin + kGroupColumns / 2)];
    const RayTerms ray = sumOf(middle, rowTerms(first));
    double w0 = 0;
    if (std::isfinite(nearest)) {
        const double w = (static_cast<double>(nearest) - ray[kTermForward0]) / ray[kTermForward];
        w0 = static_cast<double>(static_cast<float>(std::max(w, 0.0)));
    }
    // Whole cells of the tiles there, so that theirs begin at whole numbers too.
    int mip = 0;
    for (int c = begin; c < end; ++c) mip = std::max(mip, lanes_.mip[c]);
    const double cell = std::ldexp(1.0, mip);
    const auto placed = [&](double place) { return std::floor(place / cell) * cell; };
    const double anchorX = placed(ray[kTermX] + w0 * ray[kTermDx]);
    const double anchorY = placed(ray[kTermY] + w0 * ray[kTermDy]);
    const double z = ray[kTermZ] + w0 * (ray[kTermDz] + rays_.bend() * w0);
    group.anchorZ = static_cast<float>(
        std::clamp<double>(z, static_cast<double>(cut_.minZ), static_cast<double>(cut_.maxZ)));
    group.anchorX = static_cast<int32_t>(anchorX);
    group.anchorY = static_cast<int32_t>(anchorY);
    group.w0 = static_cast<float>(w0);
    group.bend = static_cast<float>(rays_.bend());
    group.exaggeration = static_cast<float>(rays_.exaggeration());
    group.eyeOutside = eyeOutside_;
    const auto moveAlong = [&](RayTerms& part) {
        part[kTermX] += w0 * part[kTermDx];
        part[kTermY] += w0 * part[kTermDy];
        part[kTermZ] += w0 * part[kTermDz];
    };
    for (size_t k = 0; k < kTermCount; ++k) {
        const double* const column = columnTerms_[k].data() + begin;
        const double* const change = columnTerms_[k <= kTermZ ? k + kTermDx : k].data() + begin;
        const double along = k <= kTermZ ? w0 : 0.0, from = middle[k],
                     changeFrom = middle[k <= kTermZ ? k + kTermDx : k];
        for (size_t c = 0; c < kMarchGroupColumns; ++c)
            group.columns[k][c] =
                static_cast<float>((column[c] - from) + along * (change[c] - changeFrom));
    }
    Reach reach;
    reach.leastRow.fill(std::numeric_limits<float>::infinity());
    reach.column = spread_;
    moveAlong(reach.column);
    const int step = neighbours_.upwards ? -1 : 1;
    for (int row = 0; row < rows; ++row) {
        RayTerms part = sumOf(rowTerms(first + row * step), middle);
        moveAlong(part);
        part[kTermX] -= anchorX;
        part[kTermY] -= anchorY;
        part[kTermZ] -= static_cast<double>(group.anchorZ);
        float* const parts = group.rows[row];
        for (size_t k = 0; k < kTermCount; ++k) parts[k] = static_cast<float>(part[k]);
        addRow(parts, reach);
    }
    group.errors = errorsOf(cut_, group, reach);
    const float speed = leastSpeed(reach);
    const bool known =
        !eyeOutside_ && speed > 0.25f * std::max(reach.row[kTermDx], reach.row[kTermDy]);
    group.span = known ? 1.001f / speed : 0.0f;
}

}  // namespace terray
