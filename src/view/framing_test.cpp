// SPDX-License-Identifier: Apache-2.0
// Tests of the view without an eye: the whole terrain fills the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "view/camera.h"

namespace terray {
namespace {

struct Seen {
    double left = 1e300, right = -1e300, top = 1e300, bottom = -1e300;
    bool all = true;
};

/// Shares of the picture that the box's corners cover, seen over the (curved) earth.
Seen cornersSeen(const Camera& camera, const SceneBox& box) {
    Seen seen;
    for (int corner = 0; corner < 8; ++corner) {
        WorldPoint p{corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                     corner & 4 ? box.max.z : box.min.z};
        const double r = std::hypot(p.x - camera.eye.x, p.y - camera.eye.y);
        p.z -= box.bend * r * r;
        const std::optional<Vec3> at = camera.project(p);
        seen.all = seen.all && at.has_value();
        if (!at) continue;
        seen.left = std::min(seen.left, at->x / camera.width);
        seen.right = std::max(seen.right, at->x / camera.width);
        seen.top = std::min(seen.top, at->y / camera.height);
        seen.bottom = std::max(seen.bottom, at->y / camera.height);
    }
    return seen;
}

void expectFramed(const View& view, const SceneBox& box) {
    const Result<Camera> camera = makeCamera(view, box);
    ASSERT_TRUE(camera.ok());
    const Seen seen = cornersSeen(*camera, box);
    ASSERT_TRUE(seen.all);
    EXPECT_GE(seen.left, 0);
    EXPECT_LE(seen.right, 1);
    EXPECT_GE(seen.top, 0);
    EXPECT_LE(seen.bottom, 1);
    EXPECT_LE(seen.top, 0.25) << "the far edge is in the upper quarter";
    const double width = seen.right - seen.left, height = seen.bottom - seen.top;
    EXPECT_LE(width, 0.9);
    if (height < 0.85) {
        EXPECT_GE(width, 0.8);
    }
    EXPECT_NEAR(seen.left, 1 - seen.right, 0.01) << "centred";
}

TEST(Framing, LooksDown28DegreesFromTheSouthSouthWest) {
    const SceneBox box{{0, 0, 100}, {10000, 8000, 900}};
    const Result<Camera> camera = makeCamera({}, box);
    ASSERT_TRUE(camera.ok());
    EXPECT_NEAR(degFromRad(camera->heading), 22.5, 1e-12);
    EXPECT_NEAR(degFromRad(camera->pitch), -28, 1e-12);
    EXPECT_LT(camera->eye.x, 5000);
    EXPECT_LT(camera->eye.y, 0);
    EXPECT_GT(camera->eye.z, 900);
    expectFramed({}, box);
}

TEST(Framing, WideFlatTerrainsAreSeenMoreSteeplyUnlessAPitchIsGiven) {
    const SceneBox box{{0, 0, 0}, {20000, 8000, 100}};
    const Result<Camera> camera = makeCamera({}, box);
    ASSERT_TRUE(camera.ok());
    EXPECT_NEAR(degFromRad(camera->pitch), -35, 1e-12);
    expectFramed({}, box);
    View given;
    given.pitchDeg = -20;
    EXPECT_NEAR(degFromRad(makeCamera(given, box)->pitch), -20, 1e-12);
    for (double depth = 8000; depth < 20000; depth += 1000) {  // in between, as far as needed
        const Result<Camera> between = makeCamera({}, {{0, 0, 0}, {20000, depth, 100}});
        const Seen seen = cornersSeen(*between, {{0, 0, 0}, {20000, depth, 100}});
        const double pitch = degFromRad(between->pitch);
        EXPECT_TRUE(seen.bottom - seen.top >= 0.6 || pitch <= -35 + 1e-9);
        EXPECT_LE(pitch, -28 + 1e-9);
    }
}

TEST(Framing, FillsThePictureForAnyBoxAndSize) {
    std::mt19937 random(11);
    const auto log10Uniform = [&](double a, double b) {
        return std::pow(10.0, std::uniform_real_distribution<double>(a, b)(random));
    };
    for (int k = 0; k < 300; ++k) {
        const double width = log10Uniform(0, 6);
        const double depth = width * log10Uniform(-1, 1);
        const double relief = k % 10 == 0 ? 0.0 : width * log10Uniform(-4, 0.5);
        SceneBox box;
        box.min = {5e5, 4e6, 1500};
        box.max = {5e5 + width, 4e6 + depth, 1500 + relief};
        View view;
        view.width = static_cast<int>(log10Uniform(1.5, 4));
        view.height = static_cast<int>(view.width * log10Uniform(-0.5, 0.5));
        expectFramed(view, box);
        if (HasFailure()) {
            FAIL() << "box " << width << " x " << depth << " x " << relief << ", " << view.width
                   << " x " << view.height;
        }
    }
}

TEST(Framing, KeepsToAGivenDirection) {
    const SceneBox box{{0, 0, 0}, {3000, 5000, 200}};
    for (const double heading : {0.0, 45.0, 180.0, 300.0}) {
        for (const double pitch : {-90.0, -60.0, -5.0, 0.0, 20.0}) {
            View view;
            view.headingDeg = heading;
            view.pitchDeg = pitch;
            const Result<Camera> camera = makeCamera(view, box);
            ASSERT_TRUE(camera.ok());
            EXPECT_NEAR(degFromRad(camera->heading), heading, 1e-9);
            EXPECT_NEAR(degFromRad(camera->pitch), pitch, 1e-9);
            expectFramed(view, box);
        }
    }
}

TEST(Framing, AllowsForTheEarthsCurvature) {
    SceneBox box{{0, 0, 0}, {800e3, 700e3, 4000}};
    box.bend = 6.8e-8;
    expectFramed({}, box);
}

TEST(Framing, SurvivesExtremeFieldsOfView) {
    const SceneBox box{{0, 0, 0}, {3000, 5000, 200}};
    for (const double fov : {0.01, 1.0, 120.0, 179.0}) {
        View view;
        view.fovDeg = fov;
        const Result<Camera> camera = makeCamera(view, box);
        ASSERT_TRUE(camera.ok());
        const Seen seen = cornersSeen(*camera, box);
        EXPECT_TRUE(seen.all);
        EXPECT_TRUE(seen.left >= 0 && seen.right <= 1 && seen.top >= 0 && seen.bottom <= 1);
    }
}

}  // namespace
}  // namespace terray
