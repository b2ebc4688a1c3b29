// SPDX-License-Identifier: Apache-2.0
// With P0 the place where the sun's elevation e holds and a the horizontal unit vector towards it,
// tan(elevation at P) = tan e + 2 c X a.(P - P0) in picture space (exaggeration X): all sun rays
// are translates of one parabola.
#include "shade/sun_rays.h"

#include <cmath>

#include "base/simd_clones.h"

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

SunDirection SunRays::direction(Vec2 onDisc) const {
    // Angular radius: the true one is 0.27 degrees; thin high clouds make it seem larger.
    constexpr double kDisc = radFromDeg(0.45);
    const Vec2 ahead = cosine_ > 0 ? horizontal_ / cosine_ : Vec2{0, 1};
    const Vec2 sideways{-ahead.y, ahead.x};
    const Vec2 aim =
        horizontal_ - ahead * (kDisc * onDisc.y * sine_) + sideways * (kDisc * onDisc.x);
    const LatticePoint step = worldFromLattice_.latticeDirection(aim);
    SunDirection sun;
    sun.dx = step.i;
    sun.dy = step.j;
    sun.bend = bend_ * glm::dot(aim, aim);
    // The slope grows along the aim itself, not along the middle of the disc: only so is a ray
    // that goes on a translate of every other one.
    const Vec2 growth = 2 * bend_ * aim;
    sun.rise = (sine_ + kDisc * onDisc.y * cosine_) / exaggeration_ +
               glm::dot(growth, worldFromLattice_.origin - centre_);
    sun.riseI = glm::dot(growth, worldFromLattice_.column);
    sun.riseJ = glm::dot(growth, worldFromLattice_.row);
    return sun;
}

namespace {

/// The sun's direction: its rise is linear in the lattice.
struct SunPlane {
    float east, north, modelling;
    float rise, perI, perJ;
};

TERRAY_SIMD_CLONES
void faceSun(const SunPlane& sun, const GroundBatch& g, Floats& facing) {
    for (int k = 0; k < kBatch; ++k) {
        const float i = static_cast<float>(g.place.x[k]) + g.place.dx[k];
        const float j = static_cast<float>(g.place.y[k]) + g.place.dy[k];
        const float rise = sun.rise + sun.perI * i + sun.perJ * j;
        const float length2 = sun.east * sun.east + sun.north * sun.north + rise * rise;
        const float nx = g.normal.x[k] * sun.modelling, ny = g.normal.y[k] * sun.modelling;
        const float nz = g.normal.z[k];
        const float cosine = nx * sun.east + ny * sun.north + nz * rise;
        const float kept = cosine > 0.0f ? cosine : 0.0f;
        facing[k] = kept / std::sqrt(length2 * (nx * nx + ny * ny + nz * nz));
    }
}

/// Plain hits on ground that faces the sun ask for it.
TERRAY_SIMD_CLONES
void askPlain(const HitBatch& hits, const Floats& facing, const Floats& height, SunAsks& asks) {
    static_assert(kSunAsks == kBatch);
    for (int k = 0; k < kBatch; ++k) {
        const float share = hits.own[k] != 0 ? facing[k] : 0.0f;
        asks.tile[k] = share > 0.0f ? static_cast<uint32_t>(hits.tile[k]) : kNoSlot;
        asks.cell[k] = hits.cell[k];
        asks.u[k] = hits.u[k];
        asks.v[k] = hits.v[k];
        asks.z[k] = height[k];
    }
}

}  // namespace

void SunRays::facing(const GroundBatch& ground, float modelling, Floats& facing) const {
    const double origin = riseAt(0, 0);
    faceSun({static_cast<float>(horizontal_.x), static_cast<float>(horizontal_.y), modelling,
             static_cast<float>(origin), static_cast<float>(riseAt(1, 0) - origin),
             static_cast<float>(riseAt(0, 1) - origin)},
            ground, facing);
}

void SunRays::ask(const HitBatch& hits, const Floats& facing, const Floats& height, SunAsks& asks) {
    if (hits.plain) {
        askPlain(hits, facing, height, asks);
        return;
    }
    for (int k = 0; k < kBatch; ++k)
        if (hits.own[k] != 0 && facing[k] > 0) asks.ask(k, hits.hit(k), height[k]);
}

}  // namespace terray
