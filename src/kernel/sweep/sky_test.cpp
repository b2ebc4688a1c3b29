// SPDX-License-Identifier: Apache-2.0
// Sky light: planes, valleys and walls against their analytic share of the sky; holes; threads.
#include "kernel/sweep/sky.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace terray {
namespace {

struct Field {
    int width, height;
    std::vector<float> z;
    Field(int w, int h)
        : width(w), height(h), z(static_cast<size_t>(w) * static_cast<size_t>(h), 0.0f) {}
    float& at(int i, int j) {
        return z[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
    }
    std::vector<float> visible(int azimuths, double stepX = 1, double stepY = 1) const {
        std::vector<float> out(z.size());
        computeSkyVisibility({z.data(), width, height, stepX, stepY}, azimuths, out);
        return out;
    }
    size_t index(int i, int j) const {
        return static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i);
    }
};

Field noise(int w, int h, uint32_t seed) {
    Field field(w, h);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> height(0, 12);
    for (float& z : field.z) z = height(random);
    return field;
}

TEST(SkyVisibility, LevelGroundSeesTheWholeSky) {
    const Field flat(37, 23);
    for (int azimuths : {4, 8, 16, 32})
        for (float v : flat.visible(azimuths)) EXPECT_NEAR(v, 1.0f, 1e-5f);
}

TEST(SkyVisibility, AnInclinedPlaneSeesHalfOfOnePlusItsCosine) {
    Field plane(201, 201);
    for (int j = 0; j < 201; ++j)
        for (int i = 0; i < 201; ++i) plane.at(i, j) = 0.8f * static_cast<float>(i);
    const auto visible = plane.visible(16);
    const double expected = 0.5 * (1 + 1 / std::sqrt(1 + 0.64));
    EXPECT_NEAR(visible[plane.index(100, 100)], expected, 0.01);
}

TEST(SkyVisibility, AValleyFloorMatchesTheAnalyticValue) {
    Field valley(401, 401);
    for (int j = 0; j < 401; ++j)
        for (int i = 0; i < 401; ++i)
            valley.at(i, j) = static_cast<float>(std::abs(i - 200)) * 1.0f;
    const auto visible = valley.visible(32);
    EXPECT_NEAR(visible[valley.index(200, 200)], 1 / std::sqrt(2.0), 0.01);
}

TEST(SkyVisibility, AWallMatchesTheAnalyticValueOnSkewedSteps) {
    Field step(301, 801);
    for (int j = 0; j < 801; ++j)
        for (int i = 150; i < 301; ++i) step.at(i, j) = 30;
    const auto visible = step.visible(32, 2.0, 1.5);
    for (int away : {4, 10, 20}) {
        const double distance = 2.0 * away;
        const double expected = 0.5 + 0.5 * distance / std::hypot(distance, 30.0);
        EXPECT_NEAR(visible[step.index(150 - away, 400)], expected, 0.02) << away;
    }
    EXPECT_NEAR(visible[step.index(200, 400)], 1.0, 1e-5);
}

TEST(SkyVisibility, EachLineIsExactAgainstBruteForce) {
    const Field field = noise(41, 29, 7);
    const auto visible = field.visible(8);
    const int steps[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    for (int j = 0; j < 29; ++j) {
        for (int i = 0; i < 41; ++i) {
            double sum = 0;
            for (const auto& step : steps) {
                double steepest = 0;
                for (int k = 1;; ++k) {
                    const int x = i + k * step[0], y = j + k * step[1];
                    if (x < 0 || y < 0 || x >= 41 || y >= 29) break;
                    const double rise = field.z[field.index(x, y)] - field.z[field.index(i, j)];
                    steepest = std::max(steepest, rise / (k * std::hypot(step[0], step[1])));
                }
                sum += 0.125 / (1 + steepest * steepest);
            }
            EXPECT_NEAR(visible[field.index(i, j)], sum, 1e-4) << i << " " << j;
        }
    }
}

TEST(SkyVisibility, HolesAreTransparentAndNeverNaN) {
    Field walled(61, 61);
    for (int j = 0; j < 61; ++j) walled.at(30, j) = std::numeric_limits<float>::quiet_NaN();
    const auto visible = walled.visible(16);
    for (float v : visible) EXPECT_NEAR(v, 1.0f, 1e-5f);
    for (int j = 0; j < 61; ++j) walled.at(31, j) = 20;
    const auto shaded = walled.visible(16);
    EXPECT_LT(shaded[walled.index(28, 30)], 0.8f);
}

TEST(SkyVisibility, DoesNotDependOnThreads) {
    const Field field = noise(203, 157, 11);
    const auto many = field.visible(16);
    const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(many, field.visible(16));
}

TEST(SkyVisibility, SmallestGridsWork) {
    for (auto [w, h] : {std::pair{1, 1}, {2, 1}, {1, 5}, {2, 2}, {3, 2}})
        for (float v : Field(w, h).visible(16)) EXPECT_NEAR(v, 1.0f, 1e-5f);
}

}  // namespace
}  // namespace terray
