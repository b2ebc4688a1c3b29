// SPDX-License-Identifier: Apache-2.0
// Picture space to lattice space. With X the exaggeration, picture space has z' = X z. A sight line
// over a curved earth is z(r) = z0 + (dz'/X) t + c r^2 in true heights, and r = |d_h| t with d_h
// the horizontal part of the unit picture direction: bend = c |d_h|^2, and the drop is exaggerated
// along with everything else when z is multiplied by X again.
#include "view/ray_frame.h"

#include "base/assert.h"

namespace terray {

RayFrame::RayFrame(const Camera& camera, const Affine2& worldFromLattice, double exaggeration,
                   double bendPerMetre2)
    : camera_(camera),
      worldFromLattice_(worldFromLattice),
      exaggeration_(exaggeration),
      bend_(camera.projection == Projection::Ortho ? 0.0 : bendPerMetre2) {
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
