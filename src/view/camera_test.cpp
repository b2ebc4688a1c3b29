// SPDX-License-Identifier: Apache-2.0
// Tests of the camera's conventions: where pixels look, and that projecting is the inverse.
#include "view/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace terray {
namespace {

const SceneBox kBox{{0, 0, 0}, {1000, 1000, 100}};

View viewFrom(double x, double y, double z) {
    View view;
    view.eye = Place{x, y, z, false};
    view.headingDeg = 0;
    view.pitchDeg = 0;
    return view;
}

Camera cameraOf(const View& view, const SceneBox& box = kBox) {
    Result<Camera> camera = makeCamera(view, box);
    EXPECT_TRUE(camera.ok()) << (camera.ok() ? "" : camera.error().message);
    return camera.ok() ? *camera : Camera{};
}

std::string errorOf(const View& view) {
    const Result<Camera> camera = makeCamera(view, kBox);
    if (camera.ok()) return "";
    EXPECT_EQ(camera.error().code, ErrorCode::Usage);
    return camera.error().message;
}

void expectNear(const Vec3& a, const Vec3& b, double tolerance) {
    EXPECT_NEAR(a.x, b.x, tolerance);
    EXPECT_NEAR(a.y, b.y, tolerance);
    EXPECT_NEAR(a.z, b.z, tolerance);
}

Vec3 centreDirection(const Camera& camera) {
    return camera.rayThrough(0.5 * camera.width, 0.5 * camera.height).direction;
}

TEST(Camera, HeadingCountsClockwiseFromNorth) {
    View view = viewFrom(0, 0, 0);
    expectNear(centreDirection(cameraOf(view)), {0, 1, 0}, 0);
    view.headingDeg = 90;
    expectNear(centreDirection(cameraOf(view)), {1, 0, 0}, 0);
    view.headingDeg = -90;
    expectNear(centreDirection(cameraOf(view)), {-1, 0, 0}, 0);
    view.headingDeg = 540;
    expectNear(centreDirection(cameraOf(view)), {0, -1, 0}, 0);
}

TEST(Camera, PitchDownIsNegative) {
    View view = viewFrom(0, 0, 0);
    view.pitchDeg = -30;
    expectNear(centreDirection(cameraOf(view)), {0, std::sqrt(0.75), -0.5}, 1e-15);
}

TEST(Camera, RowsGoDownAndColumnsGoRight) {
    const Camera camera = cameraOf(viewFrom(0, 0, 0));
    const Vec3 upperLeft = camera.rayThrough(0, 0).direction;
    const Vec3 lowerRight = camera.rayThrough(camera.width, camera.height).direction;
    EXPECT_LT(upperLeft.x, 0);
    EXPECT_GT(upperLeft.z, 0);
    EXPECT_GT(lowerRight.x, 0);
    EXPECT_LT(lowerRight.z, 0);
}

TEST(Camera, FieldOfViewIsVertical) {
    View view = viewFrom(0, 0, 0);
    view.fovDeg = 60;
    view.width = 123;
    view.height = 321;
    const Camera camera = cameraOf(view);
    const Vec3 top = camera.rayThrough(61.5, 0).direction;
    EXPECT_NEAR(degFromRad(std::asin(top.z)), 30, 1e-9);
    EXPECT_NEAR(camera.focalPixels(), 160.5 / std::tan(radFromDeg(30)), 1e-9);
}

TEST(Camera, RollClockwisePutsTheRightSideDown) {
    View view = viewFrom(0, 0, 0);
    view.rollDeg = 20;
    const Camera camera = cameraOf(view);
    const Vec3 rightSide = camera.rayThrough(camera.width, 0.5 * camera.height).direction;
    EXPECT_LT(rightSide.z, 0);
    EXPECT_NEAR(camera.right.z, -std::sin(radFromDeg(20)), 1e-15);
}

TEST(Camera, StraightDownAndUpTakeTheUpVectorFromTheHeading) {
    View view = viewFrom(0, 0, 0);
    view.headingDeg = 90;
    view.pitchDeg = -90;
    const Camera down = cameraOf(view);
    expectNear(down.forward, {0, 0, -1}, 0);
    expectNear(down.up, {1, 0, 0}, 0);
    view.pitchDeg = 90;
    const Camera up = cameraOf(view);
    expectNear(up.forward, {0, 0, 1}, 0);
    expectNear(up.up, {-1, 0, 0}, 0);
}

TEST(Camera, LookAtPutsTheTargetInTheMiddle) {
    View view;
    view.eye = Place{10, 20, 300, false};
    view.lookAt = Place{510, -80, 50, false};
    const std::optional<Vec3> seen = cameraOf(view).project({510, -80, 50});
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, 960, 1e-6);
    EXPECT_NEAR(seen->y, 540, 1e-6);
    view.lookAt = Place{10, 20, 50, false};
    expectNear(cameraOf(view).forward, {0, 0, -1}, 0);
    expectNear(cameraOf(view).up, {0, 1, 0}, 0);
}

TEST(Camera, LookAtAimsBelowByTheCurvature) {
    View view;
    view.eye = Place{0, 0, 100, false};
    view.lookAt = Place{0, 1e5, 100, false};
    SceneBox box = kBox;
    box.bend = 7e-8;
    EXPECT_NEAR(std::tan(cameraOf(view, box).pitch), -7e-8 * 1e5, 1e-12);
}

TEST(Camera, AnEyeAloneLooksAtTheMiddleOfTheTerrain) {
    View view;
    view.eye = Place{-2000, 500, 900, false};
    const std::optional<Vec3> seen = cameraOf(view).project({500, 500, 50});
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x, 960, 1e-6);
    EXPECT_NEAR(seen->y, 540, 1e-6);
}

TEST(Camera, NothingBehindTheEyeIsProjected) {
    EXPECT_FALSE(cameraOf(viewFrom(0, 0, 0)).project({0, -1, 0}));
}

TEST(Panorama, WidthIsAFullTurnWithTheHeadingInTheMiddle) {
    View view = viewFrom(0, 0, 0);
    view.projection = Projection::Panorama;
    view.headingDeg = 90;
    view.width = 720;
    view.height = 100;
    const Camera camera = cameraOf(view);
    expectNear(camera.rayThrough(360, 50).direction, {1, 0, 0}, 1e-12);
    expectNear(camera.rayThrough(540, 50).direction, {0, -1, 0}, 1e-12);
    expectNear(camera.rayThrough(0, 50).direction, camera.rayThrough(720, 50).direction, 1e-12);
}

TEST(Panorama, PixelsAreSquareAndVerticalIsLinearInTheTangent) {
    View view = viewFrom(0, 0, 0);
    view.projection = Projection::Panorama;
    view.width = 720;
    view.height = 400;
    const Camera camera = cameraOf(view);
    const double radius = 720 / (2 * kPi);
    for (const double py : {0.0, 100.0, 333.0}) {
        const Vec3 d = camera.rayThrough(360, py).direction;
        EXPECT_NEAR(d.z / std::hypot(d.x, d.y), (200 - py) / radius, 1e-12);
    }
    EXPECT_NEAR(camera.focalPixels(), radius, 1e-12);
    EXPECT_NEAR(camera.maxTangent(), 200 / radius, 1e-12);
}

TEST(Panorama, HasNorthAndTheHorizonInTheMiddleUnlessTold) {
    View view;
    view.projection = Projection::Panorama;
    view.eye = Place{500, 500, 1e5, false};
    expectNear(centreDirection(cameraOf(view)), {0, 1, 0}, 0);
}

TEST(Panorama, PitchOnlyShiftsTheStrip) {
    View view = viewFrom(0, 0, 0);
    view.projection = Projection::Panorama;
    const Camera level = cameraOf(view);
    view.pitchDeg = -10;
    const Camera shifted = cameraOf(view);
    const double rows = std::tan(radFromDeg(10)) * level.focalPixels();
    expectNear(level.rayThrough(100, 700 + rows).direction, shifted.rayThrough(100, 700).direction,
               1e-12);
}

TEST(Ortho, DefaultsToTheWholeTerrainFromAboveNorthUp) {
    View view;
    view.projection = Projection::Ortho;
    view.width = 500;
    view.height = 500;
    const Camera camera = cameraOf(view);
    EXPECT_TRUE(camera.georeferenced);
    EXPECT_EQ(camera.orthoSize, Vec2(1000, 1000));
    EXPECT_EQ(camera.metresPerPixel(), 2);
    const WorldRay ray = camera.rayThrough(0, 0);
    expectNear(ray.direction, {0, 0, -1}, 0);
    EXPECT_EQ(ray.origin.x, 0);
    EXPECT_EQ(ray.origin.y, 1000);
    EXPECT_GT(ray.origin.z, 100);
}

TEST(Ortho, ExtentIsEnlargedToThePicturesShape) {
    View view;
    view.projection = Projection::Ortho;
    view.width = 400;
    view.height = 100;
    view.extent = Extent{100, 200, 300, 300};
    const Camera camera = cameraOf(view);
    EXPECT_DOUBLE_EQ(camera.orthoSize.x, 400);
    EXPECT_DOUBLE_EQ(camera.orthoSize.y, 100);
    EXPECT_DOUBLE_EQ(camera.rayThrough(0, 0).origin.x, 0);
    EXPECT_DOUBLE_EQ(camera.rayThrough(0, 100).origin.y, 200);
}

TEST(Ortho, TurnedOrTiltedPicturesAreNotGeoreferenced) {
    View view;
    view.projection = Projection::Ortho;
    view.headingDeg = 360;
    EXPECT_TRUE(cameraOf(view).georeferenced);
    view.headingDeg = 10;
    EXPECT_FALSE(cameraOf(view).georeferenced);
    view.headingDeg.reset();
    view.pitchDeg = -45;
    const Camera tilted = cameraOf(view);
    EXPECT_FALSE(tilted.georeferenced);
    for (int corner = 0; corner < 8; ++corner) {
        const std::optional<Vec3> seen = tilted.project(
            {corner & 1 ? 1000. : 0., corner & 2 ? 1000. : 0., corner & 4 ? 100. : 0.});
        ASSERT_TRUE(seen);
        EXPECT_GT(seen->z, 0) << "the eye is in front of everything";
        EXPECT_TRUE(seen->x >= -1e-6 && seen->x <= 1920 + 1e-6);
        EXPECT_TRUE(seen->y >= -1e-6 && seen->y <= 1080 + 1e-6);
    }
}

TEST(Camera, ProjectIsTheInverseOfRayThrough) {
    std::mt19937 random(7);
    const auto uniform = [&](double a, double b) {
        return std::uniform_real_distribution<double>(a, b)(random);
    };
    for (int k = 0; k < 3000; ++k) {
        View view = viewFrom(uniform(-1e7, 1e7), uniform(-1e7, 1e7), uniform(-500, 9000));
        view.projection = static_cast<Projection>(k % 3);
        view.width = static_cast<int>(uniform(1, 4000));
        view.height = static_cast<int>(uniform(1, 4000));
        view.headingDeg = uniform(-400, 400);
        view.pitchDeg = uniform(-60, 60);
        if (view.projection == Projection::Perspective) {
            view.pitchDeg = uniform(-90, 90);
            view.rollDeg = uniform(-180, 180);
            view.fovDeg = uniform(1, 160);
        }
        if (view.projection == Projection::Ortho) view.eye.reset();
        const Camera camera = cameraOf(view);
        const double px = uniform(0.001, 0.999) * view.width;
        const double py = uniform(0, 1) * view.height;
        const WorldRay ray = camera.rayThrough(px, py);
        EXPECT_NEAR(glm::length(ray.direction), 1, 1e-12);
        const std::optional<Vec3> seen =
            camera.project(ray.origin + uniform(1e3, 1e5) * ray.direction);
        ASSERT_TRUE(seen);
        const double tolerance = 1e-8 * (1 + camera.focalPixels());
        EXPECT_NEAR(seen->x, px, tolerance + 1e-6);
        EXPECT_NEAR(seen->y, py, tolerance + 1e-6);
    }
}

TEST(Camera, RefusesSizesAndNumbersOutOfRange) {
    const auto broken = [](auto&& change) {
        View view = viewFrom(0, 0, 0);
        change(view);
        return errorOf(view);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(broken([](View& v) { v.width = 0; }), testing::HasSubstr("--size"));
    EXPECT_THAT(broken([](View& v) { v.height = 1000001; }), testing::HasSubstr("--size"));
    EXPECT_THAT(broken([](View& v) { v.fovDeg = 0; }), testing::HasSubstr("--fov"));
    EXPECT_THAT(broken([](View& v) { v.fovDeg = 179.5; }), testing::HasSubstr("--fov"));
    EXPECT_THAT(broken([](View& v) { v.pitchDeg = -91; }), testing::HasSubstr("--pitch"));
    EXPECT_THAT(broken([=](View& v) { v.headingDeg = nan; }), testing::HasSubstr("--heading"));
    EXPECT_THAT(broken([=](View& v) { v.eye->z = 1 / 0.0; }), testing::HasSubstr("--eye"));
    EXPECT_THAT(broken([](View& v) {
                    v.lookAt = Place{1, 2, 3, false};
                }),
                testing::HasSubstr("--look-at"));
}

TEST(Camera, RefusesWhatDoesNotGoTogether) {
    View same;
    same.eye = same.lookAt = Place{1, 2, 3, false};
    EXPECT_THAT(errorOf(same), testing::HasSubstr("same place"));
    View noEye;
    noEye.lookAt = Place{1, 2, 3, false};
    EXPECT_THAT(errorOf(noEye), testing::HasSubstr("--eye"));
    View panorama = viewFrom(0, 0, 0);
    panorama.projection = Projection::Panorama;
    panorama.rollDeg = 5;
    EXPECT_THAT(errorOf(panorama), testing::HasSubstr("--roll"));
    panorama.rollDeg = 0;
    panorama.pitchDeg = 90;
    EXPECT_THAT(errorOf(panorama), testing::HasSubstr("--pitch"));
    View ortho;
    ortho.projection = Projection::Ortho;
    ortho.extent = Extent{5, 0, 5, 10};
    EXPECT_THAT(errorOf(ortho), testing::HasSubstr("--extent"));
    ortho.extent.reset();
    ortho.fovDeg = 30;
    EXPECT_THAT(errorOf(ortho), testing::HasSubstr("--fov"));
}

}  // namespace
}  // namespace terray
