// SPDX-License-Identifier: Apache-2.0
// The next camera by the last two.
#include "engine/motion.h"

#include <algorithm>
#include <cmath>

namespace terray {
namespace {

constexpr double kLongestStep = 1;    ///< seconds between pictures of one motion
constexpr double kLargestTurn = 0.7;  ///< radians between two pictures; more is a jump
constexpr double kFarthestTurn = 1;   ///< radians that are looked ahead

}  // namespace

void Motion::see(const Camera& camera, Time now) {
    before_ = last_;
    beforeAt_ = lastAt_;
    last_ = camera;
    lastAt_ = now;
}

std::optional<Camera> Motion::after(double seconds) const {
    if (!last_ || !before_ || last_->projection != before_->projection) return std::nullopt;
    const double step = std::chrono::duration<double>(lastAt_ - beforeAt_).count();
    if (step <= 0 || step > kLongestStep) return std::nullopt;
    const Vec3 moved = last_->eye.vec() - before_->eye.vec();
    const Vec3 turned = last_->forward - before_->forward;
    if (glm::length(turned) > kLargestTurn) return std::nullopt;
    if (glm::length(moved) == 0 && glm::length(turned) == 0) return std::nullopt;
    Camera camera = *last_;
    const double steps = seconds / step;
    const Vec3 eye = camera.eye.vec() + steps * moved;
    camera.eye = {eye.x, eye.y, eye.z};
    const double farthest = kFarthestTurn / std::max(glm::length(turned), 1e-12);
    const Vec3 forward = glm::normalize(camera.forward + std::min(steps, farthest) * turned);
    const Vec3 right = camera.right - glm::dot(camera.right, forward) * forward;
    if (glm::length(right) < 0.1) return std::nullopt;
    camera.forward = forward;
    camera.right = glm::normalize(right);
    camera.up = glm::cross(camera.right, camera.forward);
    return camera;
}

}  // namespace terray
