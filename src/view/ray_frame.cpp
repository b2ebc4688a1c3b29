// SPDX-License-Identifier: Apache-2.0
// Picture space to lattice space. With X the exaggeration, picture space has z' = X z. A sight line
// over a curved earth is z(r) = z0 + (dz'/X) t + c r^2 in true heights, and r = |d_h| t with d_h
// the horizontal part of the unit picture direction: bend = c |d_h|^2, and the drop is exaggerated
// along with everything else when z is multiplied by X again.
#include "view/ray_frame.h"

#include <utility>

#include "base/assert.h"
#include "base/simd_clones.h"

namespace terray {

RayFrame::RayFrame(const Camera& camera, const Affine2& worldFromLattice, double exaggeration,
                   double bendPerMetre2)
    : camera_(camera),
      worldFromLattice_(worldFromLattice),
      exaggeration_(exaggeration),
      bend_(camera.projection == Projection::Ortho ? 0.0 : bendPerMetre2),
      centre_{0.5 * camera.width, 0.5 * camera.height} {
    TERRAY_ASSERT(exaggeration > 0);
    TERRAY_ASSERT(worldFromLattice.det() != 0);
    if (camera.projection != Projection::Panorama) makeLinear();
}

/// Lattice components of a world origin's and direction's change; no translation.
RayFrame::Linear RayFrame::linear(const Vec3& origin, const Vec3& direction) const {
    const LatticePoint o = worldFromLattice_.latticeDirection({origin.x, origin.y});
    const LatticePoint d = worldFromLattice_.latticeDirection({direction.x, direction.y});
    Linear result;
    result.ray.x = o.i;
    result.ray.y = o.j;
    result.ray.z = origin.z / exaggeration_;
    result.ray.dx = d.i;
    result.ray.dy = d.j;
    result.ray.dz = direction.z / exaggeration_;
    result.east = direction.x;
    result.north = direction.y;
    return result;
}

void RayFrame::makeLinear() {
    const bool ortho = camera_.projection == Projection::Ortho;
    const Vec3 none{0, 0, 0};
    const double perX = ortho ? camera_.orthoSize.x / camera_.width : 1.0 / camera_.focalPixels();
    const double perY = ortho ? camera_.orthoSize.y / camera_.height : 1.0 / camera_.focalPixels();
    const Vec3 stepX = perX * camera_.right, stepY = -perY * camera_.up;
    const LatticePoint eye = worldFromLattice_.latticeFromWorld({camera_.eye.x, camera_.eye.y});
    base_ = linear(none, camera_.forward);
    base_.ray.x += eye.i;
    base_.ray.y += eye.j;
    base_.ray.z += camera_.eye.z / exaggeration_;
    base_.ray.tMin = 0;
    alongX_ = linear(ortho ? stepX : none, ortho ? none : stepX);
    alongY_ = linear(ortho ? stepY : none, ortho ? none : stepY);
    const Vec2 level{camera_.forward.x, camera_.forward.y}, top{camera_.up.x, camera_.up.y};
    const bool vertical = glm::dot(level, level) < 1e-12;
    const Vec2 ahead = vertical ? (camera_.forward.z < 0 ? top : -top) : level;
    ahead_ = glm::normalize(ahead);
    if (ortho) {
        originX_ = {stepX.x, stepX.y};
        originY_ = {stepY.x, stepY.y};
    }
}

RayFrame RayFrame::turned() const {
    TERRAY_ASSERT(camera_.projection != Projection::Panorama);
    RayFrame frame = *this;
    std::swap(frame.alongX_, frame.alongY_);
    std::swap(frame.originX_, frame.originY_);
    std::swap(frame.centre_.x, frame.centre_.y);
    return frame;
}

RayFrame RayFrame::lookingAside() const {
    RayFrame frame = *this;
    frame.ahead_ = {ahead_.y, -ahead_.x};
    return frame;
}

RayTerms RayFrame::termsOf(const Linear& part, double steps) const {
    const Ray& r = part.ray;
    return {r.x * steps,  r.y * steps,  r.z * steps,
            r.dx * steps, r.dy * steps, r.dz * steps,
            0.0,          0.0,          (part.east * ahead_.x + part.north * ahead_.y) * steps};
}

RayTerms RayFrame::columnTerms(double px) const {
    if (camera_.projection == Projection::Panorama) {
        const WorldRay ray = camera_.rayThrough(px, 0.5 * camera_.height);
        const double level = 1.0 / std::hypot(ray.direction.x, ray.direction.y);
        const LatticePoint d =
            worldFromLattice_.latticeDirection({ray.direction.x * level, ray.direction.y * level});
        return {0, 0, 0, d.i, d.j, 0, 0, 0, 0};
    }
    const double steps = px - centre_.x;
    RayTerms terms = termsOf(alongX_, steps);
    if (camera_.projection == Projection::Ortho)
        terms[kTermForward0] = glm::dot(originX_, ahead_) * steps;
    else
        terms[kTermLength2] = steps * steps / (camera_.focalPixels() * camera_.focalPixels());
    return terms;
}

RayTerms RayFrame::rowTerms(double py) const {
    if (camera_.projection == Projection::Panorama) {
        const WorldRay ray = camera_.rayThrough(0.5 * camera_.width, py);
        const double rise = ray.direction.z / std::hypot(ray.direction.x, ray.direction.y);
        const LatticePoint eye = worldFromLattice_.latticeFromWorld({camera_.eye.x, camera_.eye.y});
        return {eye.i,
                eye.j,
                camera_.eye.z / exaggeration_,
                0,
                0,
                rise / exaggeration_,
                1.0 + rise * rise,
                0,
                1};
    }
    const double steps = py - centre_.y;
    RayTerms terms = termsOf(base_, 1.0);
    const RayTerms along = termsOf(alongY_, steps);
    for (size_t k = 0; k < terms.size(); ++k) terms[k] += along[k];
    terms[kTermLength2] = 1.0;
    if (camera_.projection == Projection::Ortho)
        terms[kTermForward0] = glm::dot(originY_, ahead_) * steps;
    else
        terms[kTermLength2] += steps * steps / (camera_.focalPixels() * camera_.focalPixels());
    return terms;
}

namespace {

/// What the loop below needs of a frame, in plain numbers: value at the centre, per pixel along x
/// and y.
struct LinearRays {
    double x[3], y[3], z[3], dx[3], dy[3], dz[3], east[3], north[3];
    double exaggeration, bend, w;
};

TERRAY_SIMD_CLONES
void fillLinear(const LinearRays& r, const double* px, const double* py, int count, RayBatch& b) {
    const auto at = [](const double(&c)[3], double i, double j) {
        return c[0] + i * c[1] + j * c[2];
    };
    for (int k = 0; k < count; ++k) {
        const double i = px[k], j = py[k];
        const double east = at(r.east, i, j), north = at(r.north, i, j), dz = at(r.dz, i, j);
        const double rise = dz * r.exaggeration, level = east * east + north * north;
        const double length = std::sqrt(level + rise * rise), s = 1.0 / length;
        b.x[k] = at(r.x, i, j);
        b.y[k] = at(r.y, i, j);
        b.z[k] = at(r.z, i, j);
        b.dx[k] = at(r.dx, i, j) * s;
        b.dy[k] = at(r.dy, i, j) * s;
        b.dz[k] = dz * s;
        b.bend[k] = r.bend * level * (s * s);
        b.begin[k] = 0.0;
        b.end[k] = 1e30;
        b.clear[k] = r.w * length;
    }
}

}  // namespace

void RayFrame::fillBatch(std::span<const double> px, std::span<const double> py, double w,
                         RayBatch& batch) const {
    const size_t count = px.size();
    TERRAY_ASSERT(count <= kBatchRays && py.size() == count);
    if (camera_.projection == Projection::Panorama) {
        for (size_t k = 0; k < count; ++k) {
            const PencilRay pencil = panoramaRay(px[k], py[k]);
            batch.set(static_cast<int>(k), unitRay(pencil));
            batch.clear[k] = w * pencil.length;
        }
        return;
    }
    const Linear &a = base_, &i = alongX_, &j = alongY_;
    const LinearRays r{{a.ray.x, i.ray.x, j.ray.x},
                       {a.ray.y, i.ray.y, j.ray.y},
                       {a.ray.z, i.ray.z, j.ray.z},
                       {a.ray.dx, i.ray.dx, j.ray.dx},
                       {a.ray.dy, i.ray.dy, j.ray.dy},
                       {a.ray.dz, i.ray.dz, j.ray.dz},
                       {a.east, i.east, j.east},
                       {a.north, i.north, j.north},
                       exaggeration_,
                       bend_,
                       w};
    double fromCentreX[kBatchRays], fromCentreY[kBatchRays];
    for (size_t k = 0; k < count; ++k) {
        fromCentreX[k] = px[k] - centre_.x;
        fromCentreY[k] = py[k] - centre_.y;
    }
    fillLinear(r, fromCentreX, fromCentreY, static_cast<int>(count), batch);
}

RayFrame::PencilRay RayFrame::panoramaRay(double px, double py) const {
    const WorldRay ray = camera_.rayThrough(px, py);
    const double length = 1.0 / std::hypot(ray.direction.x, ray.direction.y);
    PencilRay pencil{latticeRay(ray), length};
    pencil.ray.dx *= length;
    pencil.ray.dy *= length;
    pencil.ray.dz *= length;
    pencil.ray.bend *= length * length;
    return pencil;
}

Ray RayFrame::latticeRay(const WorldRay& ray) const {
    const Vec2 horizontal{ray.direction.x, ray.direction.y};
    const LatticePoint origin = worldFromLattice_.latticeFromWorld({ray.origin.x, ray.origin.y});
    const LatticePoint direction = worldFromLattice_.latticeDirection(horizontal);
    Ray result;
    result.x = origin.i;
    result.y = origin.j;
    result.z = ray.origin.z / exaggeration_;
    result.dx = direction.i;
    result.dy = direction.j;
    result.dz = ray.direction.z / exaggeration_;
    result.bend = bend_ * glm::dot(horizontal, horizontal);
    return result;
}

WorldPoint RayFrame::pointAt(const Ray& ray, double t) const {
    const Vec2 place = worldFromLattice_.worldFromLattice({ray.x + ray.dx * t, ray.y + ray.dy * t});
    return {place.x, place.y, exaggeration_ * (ray.z + (ray.dz + ray.bend * t) * t)};
}

}  // namespace terray
