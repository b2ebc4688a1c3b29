// SPDX-License-Identifier: Apache-2.0
// Splines and moving means: through their values, with continuous speed, and no overshoot.
#include "flight/spline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "flight/smooth.h"

namespace terray {
namespace {

struct Sample {
    std::vector<double> knots, numbers;
    std::vector<Vec3> places;
};

Sample randomSample(unsigned seed, int count) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> step(0.05, 4), value(-1000, 1000);
    Sample s;
    double t = -3;
    for (int k = 0; k < count; ++k) {
        t += step(random);
        s.knots.push_back(t);
        s.numbers.push_back(value(random));
        s.places.emplace_back(value(random), value(random), value(random));
    }
    return s;
}

TEST(Spline, PassesThroughItsValuesExactly) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Sample s = randomSample(seed, 1 + static_cast<int>(seed));
        const auto places = smoothSpline(s.knots, s.places);
        const auto numbers = monotoneSpline(s.knots, s.numbers);
        for (size_t k = 0; k < s.knots.size(); ++k) {
            EXPECT_EQ(places.at(s.knots[k]), s.places[k]);
            EXPECT_EQ(numbers.at(s.knots[k]), s.numbers[k]);
        }
        EXPECT_EQ(numbers.at(s.knots.front() - 1), s.numbers.front());
        EXPECT_EQ(numbers.at(s.knots.back() + 1), s.numbers.back());
    }
}

TEST(Spline, SpeedIsContinuousAtKnots) {
    constexpr double kStep = 1e-7;
    for (unsigned seed = 0; seed < 20; ++seed) {
        const Sample s = randomSample(seed, 8);
        const auto places = smoothSpline(s.knots, s.places);
        const auto numbers = monotoneSpline(s.knots, s.numbers);
        for (size_t k = 1; k + 1 < s.knots.size(); ++k) {
            const double t = s.knots[k];
            const Vec3 before = (places.at(t) - places.at(t - kStep)) / kStep;
            const Vec3 after = (places.at(t + kStep) - places.at(t)) / kStep;
            EXPECT_LT(glm::length(after - before), 1);
            EXPECT_LT(glm::length(after - places.slopeAt(t)), 1);
            const double a = (numbers.at(t) - numbers.at(t - kStep)) / kStep;
            const double b = (numbers.at(t + kStep) - numbers.at(t)) / kStep;
            EXPECT_NEAR(a, b, 1);
        }
    }
}

TEST(Spline, NumbersNeverLeaveTheRangeOfTheirNeighbours) {
    for (unsigned seed = 0; seed < 50; ++seed) {
        const Sample s = randomSample(seed, 9);
        const auto spline = monotoneSpline(s.knots, s.numbers);
        for (size_t k = 0; k + 1 < s.knots.size(); ++k) {
            const auto [low, high] = std::minmax(s.numbers[k], s.numbers[k + 1]);
            double last = s.numbers[k];
            for (int step = 1; step <= 50; ++step) {
                const double value = spline.at(std::lerp(s.knots[k], s.knots[k + 1], step / 50.0));
                EXPECT_GE(value, low - 1e-9);
                EXPECT_LE(value, high + 1e-9);
                EXPECT_GE((value - last) * (s.numbers[k + 1] - s.numbers[k]), -1e-6);
                last = value;
            }
        }
    }
}

TEST(Spline, WhatRestsStaysAtRest) {
    const Vec3 here{100, 200, 300};
    const auto spline = smoothSpline({0, 1, 2, 3}, {{0, 0, 0}, here, here, {900, 0, 0}});
    for (double t = 1; t <= 2; t += 0.05) EXPECT_LT(glm::length(spline.at(t) - here), 1e-9) << t;
}

TEST(Spline, StraightAndEvenStaysStraightAndEven) {
    const auto spline = smoothSpline({0, 1, 3, 4}, {{0, 0, 5}, {10, 2, 5}, {30, 6, 5}, {40, 8, 5}});
    for (double t = 0; t <= 4; t += 0.1)
        EXPECT_LT(glm::length(spline.at(t) - Vec3(10 * t, 2 * t, 5)), 1e-9) << t;
}

TEST(Smooth, KeepsStraightLinesAndEnds) {
    std::vector<double> line, noise;
    std::mt19937 random(5);
    for (int k = 0; k < 100; ++k) {
        line.push_back(5e6 + 3.5 * k);
        noise.push_back(static_cast<double>(random() % 1000));
    }
    const auto smoothLine = smoothed(line, 12, Beyond::Continued);
    for (size_t k = 0; k < line.size(); ++k) EXPECT_NEAR(smoothLine[k], line[k], 1e-6);
    const auto smooth = smoothed(noise, 12, Beyond::Continued);
    EXPECT_NEAR(smooth.front(), noise.front(), 1e-9);
    EXPECT_NEAR(smooth.back(), noise.back(), 1e-9);
}

TEST(Smooth, MirroredMeansStayWithinTheValues) {
    std::vector<double> values(50, 0.0);
    values[25] = 1;
    double sum = 0;
    for (const double v : smoothed(values, 9, Beyond::Mirrored)) {
        EXPECT_GE(v, 0);
        EXPECT_LE(v, 1);
        sum += v;
    }
    EXPECT_NEAR(sum, 1, 1e-9);
}

TEST(Smooth, WindowMaximumIsTheLargestNearby) {
    std::mt19937 random(7);
    std::vector<double> values;
    for (int k = 0; k < 200; ++k) values.push_back(static_cast<double>(random() % 100));
    for (const size_t reach : {size_t{0}, size_t{3}, size_t{500}}) {
        const auto highest = windowMaximum(values, reach);
        for (size_t k = 0; k < values.size(); ++k) {
            const size_t from = k > reach ? k - reach : 0,
                         to = std::min(k + reach + 1, values.size());
            EXPECT_EQ(highest[k], *std::max_element(values.begin() + static_cast<ptrdiff_t>(from),
                                                    values.begin() + static_cast<ptrdiff_t>(to)));
        }
    }
}

}  // namespace
}  // namespace terray
