// SPDX-License-Identifier: Apache-2.0
// Errors and slopes of coarser posts (coarse_fitter.cpp makes the posts).
#include "tile/mips.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/simd_clones.h"

namespace terray {

float coarsePost(const PostView& fine, int64_t i, int64_t j) {
    const auto at = [&](int64_t x, int64_t y) {
        x = std::clamp<int64_t>(x, 0, fine.width - 1);
        y = std::clamp<int64_t>(y, 0, fine.height - 1);
        return fine.posts[y * fine.stride + x];
    };
    if (std::isnan(at(2 * i, 2 * j))) return std::numeric_limits<float>::quiet_NaN();
    float sum = 0, weights = 0;
    for (int64_t dy = -1; dy <= 1; ++dy) {
        for (int64_t dx = -1; dx <= 1; ++dx) {
            const float post = at(2 * i + dx, 2 * j + dy);
            if (std::isnan(post)) continue;
            const float weight = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
            sum += weight * post;
            weights += weight;
        }
    }
    return sum / weights;
}

namespace {

/// out[k] = a[k] + weight * (b[k] - a[k]).
TERRAY_SIMD_CLONES
void lerpRows(const float* a, const float* b, float weight, int count, float* out) {
    for (int k = 0; k < count; ++k) out[k] = a[k] + weight * (b[k] - a[k]);
}

/// One doubling: in[0 .. cells] to out[0 .. 2 cells].
inline __attribute__((always_inline)) void doubleRow(const float* in, int cells, float* out) {
    for (int k = 0; k < cells; ++k) {
        out[2 * k] = in[k];
        out[2 * k + 1] = 0.5f * (in[k] + in[k + 1]);
    }
    out[2 * cells] = in[cells];
}

/// Linear interpolation: out[k], k = 0 .. cells * 2^shift, from coarse[0 .. cells]; shift >= 1.
TERRAY_SIMD_CLONES
void upsampleRow(const float* coarse, int cells, int shift, float* out, float* scratch) {
    const float* from = coarse;
    for (int step = 0; step < shift; ++step) {
        float* to = (shift - step) % 2 == 1 ? out : scratch;  // the last one lands in `out`
        doubleRow(from, cells << step, to);
        from = to;
    }
}

/// worst[k] = max(worst[k], |a[k] - b[k]|); NaN counts for nothing.
TERRAY_SIMD_CLONES
void accumulateDifference(const float* a, const float* b, int count, float* worst) {
    for (int k = 0; k < count; ++k) {
        const float difference = std::fabs(a[k] - b[k]);
        worst[k] = difference > worst[k] ? difference : worst[k];
    }
}

}  // namespace

std::span<const float> SurfaceComparer::compare(const PostRows& coarse, const PostRows& fine,
                                                int shift, int64_t column, int64_t row, int cellsX,
                                                int cellsY) {
    const int width = cellsX + 1;
    const auto rowOf = [&](int y) { return coarse_.data() + static_cast<ptrdiff_t>(y) * width; };
    coarse_.resize(static_cast<size_t>(width) * static_cast<size_t>(cellsY + 1));
    for (int y = 0; y <= cellsY; ++y) coarse.read(row + y, column, width, rowOf(y));

    const int64_t firstColumn = column << shift, firstRow = row << shift;
    const int64_t lastRow = std::min((row + cellsY) << shift, fine.rows() - 1);
    const int full = (cellsX << shift) + 1;
    const int count = static_cast<int>(std::min<int64_t>(full, fine.columns() - firstColumn));
    line_.resize(static_cast<size_t>(width));
    for (std::vector<float>* buffer : {&up_, &fine_, &scratch_}) {
        buffer->resize(static_cast<size_t>(full));
    }
    worst_.assign(static_cast<size_t>(count), 0.0f);
    for (int64_t j = firstRow; j <= lastRow; ++j) {
        const int y = static_cast<int>((j - firstRow) >> shift);
        const auto rest = static_cast<float>(j - firstRow - (int64_t{y} << shift));
        const float* from = rowOf(y);
        if (rest > 0) {
            lerpRows(from, rowOf(y + 1), std::ldexp(rest, -shift), width, line_.data());
            from = line_.data();
        }
        upsampleRow(from, cellsX, shift, up_.data(), scratch_.data());
        fine.read(j, firstColumn, count, fine_.data());
        accumulateDifference(up_.data(), fine_.data(), count, worst_.data());
    }
    return worst_;
}

float differenceRounding(float magnitude, int shift) {
    // Each interpolation step rounds by at most one ulp of the largest height: the vertical lerp
    // two steps, every doubling one, the difference one.
    return static_cast<float>(shift + 3) * 0x1p-24f * magnitude;
}

TERRAY_SIMD_CLONES
CellSteps measureCells(const float* posts, int64_t stride, int cellsX, int cellsY) {
    constexpr int kWidest = 64;
    float along[kWidest], across[kWidest], range[kWidest], holes[kWidest];
    std::fill(along, along + kWidest, 0.0f);
    std::fill(across, across + kWidest, 0.0f);
    std::fill(range, range + kWidest, 0.0f);
    std::fill(holes, holes + kWidest, 0.0f);
    for (int y = 0; y < cellsY; ++y) {
        const float* upper = posts + y * stride;
        const float* lower = upper + stride;
        for (int x = 0; x < cellsX; ++x) {
            const float a = upper[x], b = upper[x + 1], c = lower[x], d = lower[x + 1];
            const bool hole = ((a + b) + (c + d)) != ((a + b) + (c + d));
            const float ab = std::fabs(b - a), cd = std::fabs(d - c);
            const float ac = std::fabs(c - a), bd = std::fabs(d - b);
            const float ad = std::fabs(d - a), bc = std::fabs(c - b);
            const float rowStep = ab > cd ? ab : cd, columnStep = ac > bd ? ac : bd;
            const float diagonal = ad > bc ? ad : bc;
            const float edge = rowStep > columnStep ? rowStep : columnStep;
            const float whole = hole ? 0.0f : (edge > diagonal ? edge : diagonal);
            const float rowValid = hole ? 0.0f : rowStep, columnValid = hole ? 0.0f : columnStep;
            along[x] = rowValid > along[x] ? rowValid : along[x];
            across[x] = columnValid > across[x] ? columnValid : across[x];
            range[x] = whole > range[x] ? whole : range[x];
            holes[x] = hole ? 1.0f : holes[x];
        }
    }
    CellSteps steps;
    for (int x = 0; x < cellsX; ++x) {
        steps.alongRow = std::max(steps.alongRow, along[x]);
        steps.alongColumn = std::max(steps.alongColumn, across[x]);
        steps.cellRange = std::max(steps.cellRange, range[x]);
        steps.hasHoles = steps.hasHoles || holes[x] > 0;
    }
    return steps;
}

float maxWorldSlope(const CellSteps& steps, const Affine2& worldFromLattice, int mip) {
    const double size = std::ldexp(1.0, mip);
    const double a = static_cast<double>(steps.alongRow) / size;
    const double b = static_cast<double>(steps.alongColumn) / size;
    const Vec2 u = worldFromLattice.worldGradient(1, 0), v = worldFromLattice.worldGradient(0, 1);
    const double squared =
        a * a * glm::dot(u, u) + b * b * glm::dot(v, v) + 2 * a * b * std::abs(glm::dot(u, v));
    return static_cast<float>(std::sqrt(squared) * (1 + 1e-6));
}

}  // namespace terray
