// SPDX-License-Identifier: Apache-2.0
// Tests of the way from picture space to lattice space and back.
#include "view/ray_frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace terray {
namespace {

Camera cameraAt(const WorldPoint& eye, double headingDeg, double pitchDeg) {
    View view;
    view.eye = Place{eye.x, eye.y, eye.z, false};
    view.headingDeg = headingDeg;
    view.pitchDeg = pitchDeg;
    const Result<Camera> camera = makeCamera(view, {{0, 0, 0}, {1, 1, 1}});
    EXPECT_TRUE(camera.ok());
    return *camera;
}

TEST(RayFrame, PointsOnRaysAgreeWithPictureSpace) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    const Affine2 lattice{{1e7, -4e6}, {0.009, 0.004}, {0.003, -0.011}};
    for (int k = 0; k < 1000; ++k) {
        const WorldPoint eye{1e7 + 100 * unit(random), -4e6 - 100 * unit(random), 3000};
        const Camera camera = cameraAt(eye, 360 * unit(random), 180 * unit(random) - 90);
        const double exaggeration = 0.5 + 3 * unit(random);
        const RayFrame frame(camera, lattice, exaggeration, 0);
        const double px = 1920 * unit(random), py = 1080 * unit(random), t = 5000 * unit(random);
        const WorldRay world = camera.rayThrough(px, py);
        const Vec3 expected = world.origin.vec() + t * world.direction;
        const Vec3 found = frame.pointAt(frame.rayThrough(px, py), t).vec();
        EXPECT_LT(glm::length(found - expected), 1e-3) << "1 mm at offsets of 10^7 m";
    }
}

TEST(RayFrame, LatticeRaysHaveTrueHeights) {
    const Camera camera = cameraAt({0, 0, 600}, 90, -30);
    const RayFrame frame(camera, {{0, 0}, {10, 0}, {0, -10}}, 2, 0);
    const Ray ray = frame.rayThrough(960, 540);
    EXPECT_DOUBLE_EQ(ray.z, 300);
    EXPECT_DOUBLE_EQ(ray.dz, -0.25);
    EXPECT_DOUBLE_EQ(ray.dx, std::cos(radFromDeg(30)) / 10);
    EXPECT_EQ(ray.dy, 0);
}

TEST(RayFrame, BendIsTheSagOfTheTrueHorizontalDistanceExaggeratedWithTheRest) {
    const double c = 6.8e-8, exaggeration = 3;
    for (const double pitch : {0.0, -20.0, -60.0, 45.0}) {
        const Camera camera = cameraAt({0, 0, 600}, 40, pitch);
        const RayFrame curved(camera, {{5, 7}, {10, 1}, {2, -12}}, exaggeration, c);
        const RayFrame flat(camera, {{5, 7}, {10, 1}, {2, -12}}, exaggeration, 0);
        const double t = 50e3;
        const Ray ray = curved.rayThrough(700, 300);
        const WorldPoint bent = curved.pointAt(ray, t);
        const WorldPoint straight = flat.pointAt(flat.rayThrough(700, 300), t);
        const double r2 = bent.x * bent.x + bent.y * bent.y;
        EXPECT_NEAR(bent.x, straight.x, 1e-6);
        EXPECT_NEAR(bent.y, straight.y, 1e-6);
        EXPECT_NEAR(bent.z - straight.z, exaggeration * c * r2, 1e-6);
        EXPECT_NEAR(ray.z + ray.dz * t + ray.bend * t * t, bent.z / exaggeration, 1e-9);
    }
}

TEST(RayFrame, OrthoCamerasSeeAFlatEarth) {
    View view;
    view.projection = Projection::Ortho;
    view.pitchDeg = -30;
    const Result<Camera> camera = makeCamera(view, {{0, 0, 0}, {1e5, 1e5, 100}});
    ASSERT_TRUE(camera.ok());
    const RayFrame frame(*camera, {{0, 0}, {10, 0}, {0, -10}}, 1, 6.8e-8);
    EXPECT_EQ(frame.bend(), 0);
    EXPECT_EQ(frame.rayThrough(0, 0).bend, 0);
}

TEST(RayFrame, StraightDownStaysExactlyVertical) {
    const Camera camera = cameraAt({123.25, 456.5, 600}, 0, -90);
    const RayFrame frame(camera, {{0, 0}, {10, 0}, {0, -10}}, 1, 6.8e-8);
    const Ray ray = frame.rayThrough(960, 540);
    EXPECT_EQ(ray.dx, 0);
    EXPECT_EQ(ray.dy, 0);
    EXPECT_EQ(ray.dz, -1);
    EXPECT_EQ(ray.bend, 0);
}

}  // namespace
}  // namespace terray
