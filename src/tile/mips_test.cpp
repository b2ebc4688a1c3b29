// SPDX-License-Identifier: Apache-2.0
// Tests of coarser posts and of their exact errors, against brute force on small terrains.
#include "tile/mips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace terray {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class Grid final : public PostRows {
public:
    Grid(int64_t columns, int64_t rows)
        : columns_(columns), rows_(rows), posts_(static_cast<size_t>(columns * rows)) {}
    int64_t columns() const override { return columns_; }
    int64_t rows() const override { return rows_; }
    void read(int64_t row, int64_t column, int64_t count, float* out) const override {
        ASSERT_TRUE(row >= 0 && row < rows_ && column >= 0 && column + count <= columns_);
        std::copy_n(posts_.data() + row * columns_ + column, count, out);
    }
    float& at(int64_t i, int64_t j) { return posts_[static_cast<size_t>(j * columns_ + i)]; }
    float at(int64_t i, int64_t j) const { return posts_[static_cast<size_t>(j * columns_ + i)]; }
    PostView view() const { return {posts_.data(), columns_, rows_, columns_}; }
    float* data() { return posts_.data(); }

private:
    int64_t columns_, rows_;
    std::vector<float> posts_;
};

Grid hills(int64_t columns, int64_t rows, double holeShare, uint32_t seed) {
    Grid grid(columns, rows);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> noise(-4, 4);
    std::bernoulli_distribution hole(holeShare);
    for (int64_t j = 0; j < rows; ++j) {
        for (int64_t i = 0; i < columns; ++i) {
            const auto x = static_cast<float>(i), y = static_cast<float>(j);
            const float z = 60 * std::sin(0.07f * x) * std::cos(0.05f * y) + noise(random);
            grid.at(i, j) = hole(random) ? kNaN : z;
        }
    }
    return grid;
}

Grid coarser(const Grid& fine, int rounds) {
    Grid coarse(fine.columns() / 2 + 1, fine.rows() / 2 + 1);
    CoarseFitter fitter(rounds);
    fitter.fit(fine, 0, 0, static_cast<int>(coarse.columns()), static_cast<int>(coarse.rows()),
               coarse.data(), coarse.columns());
    return coarse;
}

/// Bilinear height of a grid at a place in its cells; NaN where a post that bears on it is a hole.
double heightAt(const Grid& grid, double i, double j) {
    const auto x = std::min(static_cast<int64_t>(i), grid.columns() - 2);
    const auto y = std::min(static_cast<int64_t>(j), grid.rows() - 2);
    const double u = i - static_cast<double>(x), v = j - static_cast<double>(y);
    double sum = 0;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        const double weight = (dx != 0 ? u : 1 - u) * (dy != 0 ? v : 1 - v);
        if (weight != 0) sum += weight * static_cast<double>(grid.at(x + dx, y + dy));
    }
    return sum;
}

double bruteForce(const Grid& coarse, const Grid& fine, int shift, int64_t column, int64_t row,
                  int cellsX, int cellsY) {
    const double size = std::ldexp(1.0, shift);
    double worst = 0;
    for (int64_t j = row << shift; j <= std::min((row + cellsY) << shift, fine.rows() - 1); ++j) {
        for (int64_t i = column << shift;
             i <= std::min((column + cellsX) << shift, fine.columns() - 1); ++i) {
            const double difference = std::abs(
                heightAt(coarse, static_cast<double>(i) / size, static_cast<double>(j) / size) -
                static_cast<double>(fine.at(i, j)));
            if (difference > worst) worst = difference;
        }
    }
    return worst;
}

TEST(CoarseFitter, WithoutRoundsIsTheFullWeightingMean) {
    for (const auto& [columns, rows] : {std::pair{2, 2}, {3, 2}, {5, 7}, {64, 33}, {101, 64}}) {
        const Grid fine = hills(columns, rows, 0.1, 3);
        const Grid coarse = coarser(fine, 0);
        for (int64_t j = 0; j < coarse.rows(); ++j) {
            for (int64_t i = 0; i < coarse.columns(); ++i) {
                const float expected = coarsePost(fine.view(), i, j);
                ASSERT_EQ(std::isnan(expected), std::isnan(coarse.at(i, j)));
                if (!std::isnan(expected)) {
                    EXPECT_NEAR(expected, coarse.at(i, j), 1e-4) << i << ' ' << j;
                }
            }
        }
    }
}

TEST(CoarseFitter, PostsAreValidExactlyWhereTheFinePostIs) {
    const Grid fine = hills(90, 71, 0.3, 5);
    const Grid coarse = coarser(fine, kFitRounds);
    for (int64_t j = 0; j < coarse.rows(); ++j) {
        for (int64_t i = 0; i < coarse.columns(); ++i) {
            const float below =
                fine.at(std::min(2 * i, fine.columns() - 1), std::min(2 * j, fine.rows() - 1));
            EXPECT_EQ(std::isnan(below), std::isnan(coarse.at(i, j))) << i << ' ' << j;
            EXPECT_FALSE(std::isinf(coarse.at(i, j)));
        }
    }
}

TEST(CoarseFitter, ValuesDoNotDependOnTheWindow) {
    const Grid fine = hills(203, 150, 0.02, 7);
    const Grid whole = coarser(fine, kFitRounds);
    std::mt19937 random(11);
    CoarseFitter fitter;
    for (int trial = 0; trial < 40; ++trial) {
        const auto pick = [&](int64_t low, int64_t high) {
            return std::uniform_int_distribution<int64_t>(low, high)(random);
        };
        const int64_t i0 = pick(0, whole.columns() - 1), j0 = pick(0, whole.rows() - 1);
        const auto width = static_cast<int>(pick(1, whole.columns() - i0));
        const auto height = static_cast<int>(pick(1, whole.rows() - j0));
        Grid window(width, height);
        fitter.fit(fine, i0, j0, width, height, window.data(), width);
        for (int j = 0; j < height; ++j) {
            for (int i = 0; i < width; ++i) {
                const float a = window.at(i, j), b = whole.at(i0 + i, j0 + j);
                ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << i << ' ' << j;
            }
        }
    }
}

TEST(CoarseFitter, FittingLowersTheLargestError) {
    const Grid fine = hills(257, 257, 0, 13);
    SurfaceComparer comparer;
    const auto worst = [&](int rounds) {
        const Grid coarse = coarser(fine, rounds);
        const auto errors = comparer.compare(coarse, fine, 1, 0, 0, 128, 128);
        return *std::max_element(errors.begin(), errors.end());
    };
    EXPECT_LT(worst(kFitRounds), 0.85f * worst(0));
}

TEST(CoarseFitter, PlanesStayPlanesAndConstantsConstants) {
    Grid plane(65, 65), flat(31, 18);
    for (int64_t j = 0; j < 65; ++j) {
        for (int64_t i = 0; i < 65; ++i) plane.at(i, j) = static_cast<float>(3 * i - 2 * j);
    }
    std::fill(flat.data(), flat.data() + 31 * 18, -7.25f);
    const Grid coarsePlane = coarser(plane, kFitRounds), coarseFlat = coarser(flat, kFitRounds);
    for (int64_t j = 6; j < 27; ++j) {
        for (int64_t i = 6; i < 27; ++i) {
            EXPECT_EQ(coarsePlane.at(i, j), static_cast<float>(6 * i - 4 * j));
        }
    }
    for (int64_t j = 0; j < coarseFlat.rows(); ++j) {
        for (int64_t i = 0; i < coarseFlat.columns(); ++i) EXPECT_EQ(coarseFlat.at(i, j), -7.25f);
    }
}

TEST(SurfaceComparer, EqualsBruteForceAndNeverFallsBelowIt) {
    SurfaceComparer comparer;
    std::mt19937 random(17);
    for (const double holes : {0.0, 0.03, 0.4}) {
        const Grid fine = hills(149, 131, holes, 19);
        Grid coarse = coarser(fine, kFitRounds);
        for (int shift = 1; shift <= 4; ++shift) {
            for (int trial = 0; trial < 12; ++trial) {
                const auto pick = [&](int64_t low, int64_t high) {
                    return std::uniform_int_distribution<int64_t>(low, high)(random);
                };
                const int64_t i0 = pick(0, coarse.columns() - 2), j0 = pick(0, coarse.rows() - 2);
                const auto cellsX = static_cast<int>(pick(1, coarse.columns() - 1 - i0));
                const auto cellsY = static_cast<int>(pick(1, coarse.rows() - 1 - j0));
                const auto errors = comparer.compare(coarse, fine, shift, i0, j0, cellsX, cellsY);
                const double found =
                    static_cast<double>(*std::max_element(errors.begin(), errors.end()));
                const double exact = bruteForce(coarse, fine, shift, i0, j0, cellsX, cellsY);
                const double rounding = static_cast<double>(differenceRounding(70, shift));
                EXPECT_GE(found + rounding, exact);
                EXPECT_LE(found - rounding, exact);
            }
            coarse = coarser(coarse, kFitRounds);
        }
    }
}

TEST(SurfaceComparer, NestedSurfacesDifferMostAtPosts) {
    // No place between the posts of mip 0 may differ more than the posts do.
    const Grid fine = hills(65, 65, 0, 23);
    const Grid coarse = coarser(coarser(fine, kFitRounds), kFitRounds);
    SurfaceComparer comparer;
    const auto errors = comparer.compare(coarse, fine, 2, 0, 0, 16, 16);
    const double bound = static_cast<double>(*std::max_element(errors.begin(), errors.end())) +
                         static_cast<double>(differenceRounding(70, 2));
    std::mt19937 random(29);
    std::uniform_real_distribution<double> place(0, 64);
    for (int k = 0; k < 20000; ++k) {
        const double i = place(random), j = place(random);
        ASSERT_LE(std::abs(heightAt(coarse, i / 4, j / 4) - heightAt(fine, i, j)), bound);
    }
}

TEST(MeasureCells, FindsStepsRangesAndHoles) {
    Grid grid(5, 4);
    std::fill(grid.data(), grid.data() + 20, 1.0f);
    EXPECT_FALSE(measureCells(grid.data(), 5, 4, 3).hasHoles);
    grid.at(1, 1) = 4;
    grid.at(2, 2) = -2;
    const CellSteps steps = measureCells(grid.data(), 5, 4, 3);
    EXPECT_EQ(steps.alongRow, 3);
    EXPECT_EQ(steps.alongColumn, 3);
    EXPECT_EQ(steps.cellRange, 6);
    grid.at(1, 1) = kNaN;
    grid.at(2, 2) = 9;
    const CellSteps holed = measureCells(grid.data(), 5, 4, 3);
    EXPECT_TRUE(holed.hasHoles);
    EXPECT_EQ(holed.cellRange, 8);
}

TEST(MaxWorldSlope, IsNeverBelowTheSlopeOfAnyCell) {
    Affine2 map;
    map.column = {20, 9};
    map.row = {4, -31};
    const Grid grid = hills(40, 40, 0, 31);
    const int mip = 2;
    const double bound =
        static_cast<double>(maxWorldSlope(measureCells(grid.view().posts, 40, 39, 39), map, mip));
    double steepest = 0;
    std::mt19937 random(37);
    std::uniform_real_distribution<double> place(0.01, 38.99);
    for (int k = 0; k < 20000; ++k) {
        const double i = place(random), j = place(random), h = 1e-4;
        if (std::floor(i) != std::floor(i + h) || std::floor(j) != std::floor(j + h)) continue;
        const double z = heightAt(grid, i, j);
        const Vec2 gradient = map.worldGradient((heightAt(grid, i + h, j) - z) / (4 * h),
                                                (heightAt(grid, i, j + h) - z) / (4 * h));
        steepest = std::max(steepest, glm::length(gradient));
    }
    EXPECT_GE(bound, steepest - 1e-6);
    EXPECT_LE(bound, 2 * steepest);
}

}  // namespace
}  // namespace terray
