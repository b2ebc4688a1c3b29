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
