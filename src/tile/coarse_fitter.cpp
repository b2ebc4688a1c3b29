// SPDX-License-Identifier: Apache-2.0
// Coarse posts: the full-weighting mean, then rounds that level out the residuals around each post.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/simd_clones.h"
#include "tile/mips.h"

// A window is worked on with a halo of one post a round, because a round looks one coarse post
// away. Fine row k of the window is the mip's row 2 row0 - 1 + k, split into its even and odd
// columns so that all loops run over unit strides. Outside the window everything is NaN, which the
// comparisons below (x > best ? x : best) pass over.

namespace terray {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Rows {
    const float *even, *odd;
};

/// Full weighting of one coarse row from three fine rows; odd[-1] must be readable.
TERRAY_SIMD_CLONES
void weightRow(const Rows& above, const Rows& here, const Rows& below, int count, float* sums,
               float* weights, float* out) {
    const auto known = [](float z) { return z == z ? 1.0f : 0.0f; };
    const auto value = [](float z) { return z == z ? z : 0.0f; };
    for (int i = -1; i < count; ++i) {
        sums[i] = value(above.odd[i]) + 2 * value(here.odd[i]) + value(below.odd[i]);
        weights[i] = known(above.odd[i]) + 2 * known(here.odd[i]) + known(below.odd[i]);
    }
    for (int i = 0; i < count; ++i) {
        const float a = above.even[i], b = here.even[i], c = below.even[i];
        const float sum = sums[i - 1] + 2 * (value(a) + 2 * value(b) + value(c)) + sums[i];
        const float weight = weights[i - 1] + 2 * (known(a) + 2 * known(b) + known(c)) + weights[i];
        out[i] = b == b ? sum / weight : kNaN;
    }
}

/// Residuals (coarse surface - fine post) of two fine rows: on a coarse row, and half a cell below.
struct Residuals {
    float *even, *odd, *evenBelow, *oddBelow;
};

/// Residuals of the fine row midway between two coarse rows (the same one twice: on it).
TERRAY_SIMD_CLONES
void residualRow(const float* upper, const float* lower, const Rows& fine, int count, float* even,
                 float* odd) {
    const float *fineEven = fine.even, *fineOdd = fine.odd;
    for (int i = -1; i < count; ++i) {
        const float left = 0.5f * (upper[i] + lower[i]);
        const float right = 0.5f * (upper[i + 1] + lower[i + 1]);
        even[i] = left - fineEven[i];
        odd[i] = 0.5f * (left + right) - fineOdd[i];
    }
}

/// Moves each post by half of the mid-range of the nine residuals around it.
TERRAY_SIMD_CLONES
void moveRow(const Residuals& on, const float* evenAbove, const float* oddAbove, int count,
             float* coarse) {
    const auto larger = [](float candidate, float best) {
        return candidate > best ? candidate : best;
    };
    const auto smaller = [](float candidate, float best) {
        return candidate < best ? candidate : best;
    };
    for (int i = 0; i < count; ++i) {
        float high = -kInfinity, low = kInfinity;
        for (const float r :
             {on.even[i], on.odd[i - 1], on.odd[i], on.evenBelow[i], on.oddBelow[i - 1],
              on.oddBelow[i], evenAbove[i], oddAbove[i - 1], oddAbove[i]}) {
            high = larger(r, high);
            low = smaller(r, low);
        }
        const float move = high >= low ? 0.25f * (high + low) : 0.0f;
        coarse[i] -= move;
    }
}

}  // namespace

void CoarseFitter::fit(const PostRows& fine, int64_t column, int64_t row, int width, int height,
                       float* out, int64_t stride) {
    const int64_t coarseColumns = fine.columns() / 2 + 1, coarseRows = fine.rows() / 2 + 1;
    column0_ = std::max<int64_t>(column - rounds_, 0);
    row0_ = std::max<int64_t>(row - rounds_, 0);
    width_ = static_cast<int>(std::min(column + width + rounds_, coarseColumns) - column0_);
    height_ = static_cast<int>(std::min(row + height + rounds_, coarseRows) - row0_);
    pitch_ = width_ + 2;
    const auto rowsOf = [this](int count) {
        return static_cast<size_t>(count) * static_cast<size_t>(pitch_);
    };
    coarse_.assign(rowsOf(height_ + 2), kNaN);
    even_.assign(rowsOf(2 * height_ + 1), kNaN);
    odd_.assign(rowsOf(2 * height_ + 1), kNaN);
    line_.resize(rowsOf(2));
    scratch_.assign(rowsOf(6), kNaN);
    load(fine);
    start();
    hideRepeated(fine);
    for (int round = 0; round < rounds_; ++round) improve();
    for (int j = 0; j < height; ++j) {
        const float* from = coarseRow(static_cast<int>(row - row0_) + j) + (column - column0_);
        std::copy(from, from + width, out + j * stride);
    }
}

/// Fine rows and columns beyond the mip repeat its edge.
void CoarseFitter::load(const PostRows& fine) {
    const int64_t first = 2 * column0_ - 1, count = 2 * width_ + 1;
    const int64_t from = std::max<int64_t>(first, 0);
    const int64_t to = std::min(first + count, fine.columns());
    float* line = line_.data();
    for (int k = 0; k <= 2 * height_; ++k) {
        const int64_t row = std::clamp<int64_t>(2 * row0_ - 1 + k, 0, fine.rows() - 1);
        fine.read(row, from, to - from, line + (from - first));
        std::fill(line, line + (from - first), line[from - first]);
        std::fill(line + (to - first), line + count, line[to - first - 1]);
        float* even = evenRow(k);
        float* odd = oddRow(k);
        odd[-1] = line[0];
        for (int i = 0; i < width_; ++i) {
            even[i] = line[2 * i + 1];
            odd[i] = line[2 * i + 2];
        }
    }
}

void CoarseFitter::start() {
    float* sums = scratch_.data() + 1;
    float* weights = sums + pitch_;
    for (int j = 0; j < height_; ++j) {
        const auto rows = [&](int k) { return Rows{evenRow(k), oddRow(k)}; };
        weightRow(rows(2 * j), rows(2 * j + 1), rows(2 * j + 2), width_, sums, weights,
                  coarseRow(j));
    }
}

/// Repeated edge posts are no posts of the mip: the fit must not aim at them.
void CoarseFitter::hideRepeated(const PostRows& fine) {
    const auto inside = [this](int64_t columns) {
        return static_cast<int>(std::min<int64_t>(columns - column0_, width_));
    };
    const int evens = inside((fine.columns() + 1) / 2), odds = inside(fine.columns() / 2);
    for (int k = 0; k <= 2 * height_; ++k) {
        const int64_t row = 2 * row0_ - 1 + k;
        const bool outside = row < 0 || row >= fine.rows();
        std::fill(evenRow(k) + (outside ? 0 : evens), evenRow(k) + width_, kNaN);
        std::fill(oddRow(k) + (outside ? 0 : odds), oddRow(k) + width_, kNaN);
    }
}

/// One round over all rows, from the posts before the round: a row moves only after the residuals
/// of the row below it are known.
void CoarseFitter::improve() {
    const auto scratchRow = [this](int r) { return scratch_.data() + r * pitch_ + 1; };
    Residuals on{scratchRow(0), scratchRow(1), scratchRow(2), scratchRow(3)};
    float* evenAbove = scratchRow(4);
    float* oddAbove = scratchRow(5);
    std::fill(evenAbove - 1, evenAbove + width_, kNaN);
    std::fill(oddAbove - 1, oddAbove + width_, kNaN);
    for (int j = 0; j < height_; ++j) {
        const Rows here{evenRow(2 * j + 1), oddRow(2 * j + 1)};
        const Rows below{evenRow(2 * j + 2), oddRow(2 * j + 2)};
        residualRow(coarseRow(j), coarseRow(j), here, width_, on.even, on.odd);
        residualRow(coarseRow(j), coarseRow(j + 1), below, width_, on.evenBelow, on.oddBelow);
        moveRow(on, evenAbove, oddAbove, width_, coarseRow(j));
        std::swap(on.evenBelow, evenAbove);
        std::swap(on.oddBelow, oddAbove);
    }
}

}  // namespace terray
