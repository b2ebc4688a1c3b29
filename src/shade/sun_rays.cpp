// SPDX-License-Identifier: Apache-2.0
// With P0 the place where the sun's elevation e holds and a the horizontal unit vector towards it,
// tan(elevation at P) = tan e + 2 c X a.(P - P0) in picture space (exaggeration X): all sun rays
// are translates of one parabola.
#include "shade/sun_rays.h"

#include <cmath>

namespace terray {

SunRays::SunRays(const Sun& sun, const RayFrame& rays)
    : worldFromLattice_(rays.worldFromLattice()),
      centre_(sun.centre),
      horizontal_(sun.towards.x, sun.towards.y),
      sine_(sun.towards.z),
      cosine_(std::hypot(sun.towards.x, sun.towards.y)),
      exaggeration_(rays.exaggeration()),
      bend_(rays.bend()) {}

double SunRays::riseAt(double i, double j) const {
    if (bend_ == 0 || cosine_ == 0) return sine_;
    const Vec2 away = worldFromLattice_.worldFromLattice({i, j}) - centre_;
    return sine_ + 2 * bend_ * exaggeration_ * glm::dot(horizontal_, away);
}

glm::vec3 SunRays::towardsAt(double i, double j) const {
    const Vec3 towards{horizontal_.x, horizontal_.y, riseAt(i, j)};
    return glm::vec3(bend_ == 0 ? towards : glm::normalize(towards));
}

Ray SunRays::from(double i, double j, double z, Vec2 onDisc) const {
    // Angular radius: the true one is 0.27 degrees; thin high clouds make it seem larger.
    constexpr double kDisc = radFromDeg(0.45);
    const Vec2 ahead = cosine_ > 0 ? horizontal_ / cosine_ : Vec2{0, 1};
    const Vec2 sideways{-ahead.y, ahead.x};
    const Vec2 aim =
        horizontal_ - ahead * (kDisc * onDisc.y * sine_) + sideways * (kDisc * onDisc.x);
    const LatticePoint step = worldFromLattice_.latticeDirection(aim);
    Ray ray;
    ray.x = i;
    ray.y = j;
    ray.z = z;
    ray.dx = step.i;
    ray.dy = step.j;
    ray.dz = (riseAt(i, j) + kDisc * onDisc.y * cosine_) / exaggeration_;
    ray.bend = bend_ * glm::dot(aim, aim);
    return ray;
}

}  // namespace terray
