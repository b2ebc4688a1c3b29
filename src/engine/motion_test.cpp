// SPDX-License-Identifier: Apache-2.0
// Where a camera will be: on along its way, turned as it turns; nowhere if it jumps or rests.
#include "engine/motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace terray {
namespace {

Camera cameraAt(double x, double heading) {
    Camera camera;
    camera.width = 100;
    camera.height = 80;
    camera.eye = {x, 5, 300};
    camera.forward = {std::sin(heading), std::cos(heading), 0};
    camera.right = {std::cos(heading), -std::sin(heading), 0};
    camera.up = {0, 0, 1};
    return camera;
}

Motion::Time at(double seconds) {
    return Motion::Time(
        std::chrono::duration_cast<Motion::Time::duration>(std::chrono::duration<double>(seconds)));
}

TEST(Motion, GoesOnAndTurnsOn) {
    Motion motion;
    EXPECT_FALSE(motion.after(1).has_value());
    motion.see(cameraAt(100, 0), at(1));
    EXPECT_FALSE(motion.after(1).has_value());
    motion.see(cameraAt(110, 0.02), at(1.1));
    const auto soon = motion.after(0.5);
    ASSERT_TRUE(soon.has_value());
    EXPECT_NEAR(soon->eye.x, 160, 1e-6);
    EXPECT_NEAR(soon->eye.z, 300, 1e-6);
    const Camera turned = cameraAt(0, 0.12);
    EXPECT_NEAR(glm::length(soon->forward - turned.forward), 0, 0.01);
    EXPECT_NEAR(glm::length(soon->right - turned.right), 0, 0.01);
    EXPECT_NEAR(glm::length(soon->up - turned.up), 0, 0.01);
    EXPECT_EQ(soon->width, 100);
}

TEST(Motion, OfACameraThatRestsJumpsOrWasLostThereIsNone) {
    Motion rests, jumps, lost;
    for (const double t : {1.0, 1.1}) rests.see(cameraAt(7, 1), at(t));
    jumps.see(cameraAt(7, 0), at(1));
    jumps.see(cameraAt(8, 2), at(1.1));
    lost.see(cameraAt(7, 0), at(1));
    lost.see(cameraAt(8, 0), at(4));
    for (const Motion* motion : {&rests, &jumps, &lost})
        EXPECT_FALSE(motion->after(0.5).has_value());
}

}  // namespace
}  // namespace terray
