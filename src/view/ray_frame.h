// SPDX-License-Identifier: Apache-2.0
// From pixels to the kernel's rays: picture space to lattice space, exaggeration and earth
// curvature.
#pragma once

#include <cmath>
#include <span>

#include "kernel/layout/layout.h"
#include "kernel/ray_batch.h"
#include "kernel/ray_terms.h"
#include "math/affine.h"
#include "view/camera.h"

namespace terray {

/// All rays of one frame, and of its sun, in lattice space. const-shared.
class RayFrame {
public:
    /// `bendPerMetre2` is c = (1 - k) / 2R, 0 for a flat earth and for ortho cameras.
    RayFrame(const Camera& camera, const Affine2& worldFromLattice, double exaggeration,
             double bendPerMetre2);

    /// Kernel ray through the picture position; t is metres in picture space.
    Ray rayThrough(double px, double py) const { return unitRay(pencilRay(px, py)); }
    Ray latticeRay(const WorldRay& ray) const;

    /// A ray whose parameter w is the distance along the view axis (panorama: horizontal distance),
    /// so that rays of neighbouring pixels at one w lie on a plane (cylinder) across the view: t =
    /// length w.
    struct PencilRay {
        Ray ray;
        double length = 1;
    };
    PencilRay pencilRay(double px, double py) const {
        if (camera_.projection == Projection::Panorama) return panoramaRay(px, py);
        Linear r = base_;
        r.add(px - centre_.x, alongX_);
        r.add(py - centre_.y, alongY_);
        const double horizontal = r.east * r.east + r.north * r.north;
        const double rise = r.ray.dz * exaggeration_;
        r.ray.bend = bend_ * horizontal;
        return {r.ray, std::sqrt(horizontal + rise * rise)};
    }
    /// Places in the picture to rays by distance, each known to be clear until w along its pencil
    /// ray.
    void fillBatch(std::span<const double> px, std::span<const double> py, double w,
                   RayBatch& batch) const;
    /// The parts of a pencil ray, by the sum of which kernel/columns.h knows it. "Ahead" is the
    /// horizontal direction of the view (of the picture's top edge when that is vertical).
    RayTerms columnTerms(double px) const;
    RayTerms rowTerms(double py) const;
    /// The same rays with rows and columns exchanged: pixel (py, px) is pixel (px, py) of this
    /// one. Not for panoramas.
    RayFrame turned() const;
    /// The same rays, where "ahead" is a quarter turn to the right of what it is here.
    RayFrame lookingAside() const;
    /// The same ray by distance in metres.
    static Ray unitRay(const PencilRay& pencil) {
        Ray ray = pencil.ray;
        const double s = 1.0 / pencil.length;
        ray.dx *= s;
        ray.dy *= s;
        ray.dz *= s;
        ray.bend *= s * s;
        return ray;
    }
    /// Place on a ray, in picture space.
    WorldPoint pointAt(const Ray& ray, double t) const;

    /// True height of a place on a ray.
    static double heightAt(const Ray& ray, double t) { return ray.z + (ray.dz + ray.bend * t) * t; }
    /// Unit normal of a wall between constant cells that a ray of this world direction has hit:
    /// walls stand half-way between posts, across the lattice's columns or rows.
    Vec3 wallNormal(const Hit& hit, const Vec3& direction) const {
        const bool acrossColumns = std::abs(hit.u - 0.5f) < std::abs(hit.v - 0.5f);
        const Vec2 across =
            worldFromLattice_.worldGradient(acrossColumns ? 1 : 0, acrossColumns ? 0 : 1);
        const Vec3 normal = glm::normalize(Vec3{across.x, across.y, 0});
        return glm::dot(normal, direction) > 0 ? -normal : normal;
    }

    const Camera& camera() const { return camera_; }
    const Affine2& worldFromLattice() const { return worldFromLattice_; }
    double exaggeration() const { return exaggeration_; }
    double bend() const { return bend_; }

private:
    /// A ray and the world's horizontal part of its direction: linear in the picture position.
    struct Linear {
        Ray ray;
        double east = 0, north = 0;
        void add(double s, const Linear& step) {
            ray.x += s * step.ray.x;
            ray.y += s * step.ray.y;
            ray.z += s * step.ray.z;
            ray.dx += s * step.ray.dx;
            ray.dy += s * step.ray.dy;
            ray.dz += s * step.ray.dz;
            east += s * step.east;
            north += s * step.north;
        }
    };
    Linear linear(const Vec3& origin, const Vec3& direction) const;
    PencilRay panoramaRay(double px, double py) const;
    void makeLinear();
    RayTerms termsOf(const Linear& part, double steps) const;

    Camera camera_;
    Affine2 worldFromLattice_;
    double exaggeration_, bend_;
    Linear base_, alongX_, alongY_;  ///< the ray at the picture's centre and its change per pixel
    Vec2 centre_;                    ///< of the picture, pixels
    Vec2 ahead_{0, 1};               ///< unit
    Vec2 originX_{0, 0}, originY_{0, 0};  ///< ortho: metres per pixel along x and y
};

/// Picture rectangle worked on at once.
struct ImageTile {
    int x = 0, y = 0, width = 0, height = 0;
    size_t pixelCount() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

}  // namespace terray
