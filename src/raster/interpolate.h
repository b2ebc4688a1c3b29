// SPDX-License-Identifier: Apache-2.0
// Interpolation in a rectangle of samples with holes: bicubic, bilinear beside holes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace terray {

/// Samples firstColumn.., firstRow.. of a raster of columns x rows samples; NaN for holes.
struct SampleField {
    const float* samples = nullptr;
    int64_t firstColumn = 0, firstRow = 0, width = 0;  ///< of the rectangle in memory
    int64_t columns = 0, rows = 0;                     ///< of the whole raster

    float at(int64_t i, int64_t j) const {
        return samples[(j - firstRow) * width + (i - firstColumn)];
    }
};

/// Catmull-Rom weights (Keys 1981, a = -1/2) of samples -1, 0, 1, 2 at t in 0..1.
inline std::array<float, 4> cubicWeights(float t) {
    return {0.5F * t * (-1 + t * (2 - t)), 1 + 0.5F * t * t * (-5 + 3 * t),
            0.5F * t * (1 + t * (4 - 3 * t)), 0.5F * t * t * (t - 1)};
}

/// Bilinear over the valid ones of the 4 samples around; NaN if the nearest one is a hole.
inline float bilinearSample(const SampleField& field, int64_t i, int64_t j, float u, float v) {
    const int64_t i1 = std::min(i + 1, field.columns - 1), j1 = std::min(j + 1, field.rows - 1);
    const std::array<float, 4> z{field.at(i, j), field.at(i1, j), field.at(i, j1),
                                 field.at(i1, j1)};
    const std::array<float, 4> weights{(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
    const size_t nearest = (u >= 0.5F ? 1U : 0U) + (v >= 0.5F ? 2U : 0U);
    if (std::isnan(z[nearest])) return z[nearest];
    float sum = 0, weight = 0;  // of differences to the nearest: constants stay exact
    for (size_t k = 0; k < 4; ++k) {
        if (std::isnan(z[k])) continue;
        sum += weights[k] * (z[k] - z[nearest]);
        weight += weights[k];
    }
    return z[nearest] + sum / weight;
}

/// Height at place (x, y) in samples; NaN outside the raster's pixels and in holes.
inline float interpolateSample(const SampleField& field, double x, double y) {
    const auto lastColumn = static_cast<double>(field.columns - 1);
    const auto lastRow = static_cast<double>(field.rows - 1);
    if (!(x >= -0.5 && x <= lastColumn + 0.5 && y >= -0.5 && y <= lastRow + 0.5)) {
        return std::numeric_limits<float>::quiet_NaN();
    }
    x = std::clamp(x, 0.0, lastColumn);
    y = std::clamp(y, 0.0, lastRow);
    const auto i = static_cast<int64_t>(x), j = static_cast<int64_t>(y);
    const auto u = static_cast<float>(x - static_cast<double>(i));
    const auto v = static_cast<float>(y - static_cast<double>(j));
    if (i < 1 || j < 1 || i + 2 >= field.columns || j + 2 >= field.rows) {
        return bilinearSample(field, i, j, u, v);
    }
    const std::array<float, 4> across = cubicWeights(u), down = cubicWeights(v);
    const float* row =
        &field.samples[(j - 1 - field.firstRow) * field.width + i - 1 - field.firstColumn];
    const float base = row[field.width + 1];
    float sum = 0;
    for (size_t k = 0; k < 4; ++k, row += field.width) {
        sum += down[k] * (across[0] * (row[0] - base) + across[1] * (row[1] - base) +
                          across[2] * (row[2] - base) + across[3] * (row[3] - base));
    }
    return std::isnan(sum) ? bilinearSample(field, i, j, u, v) : base + sum;
}

}  // namespace terray
