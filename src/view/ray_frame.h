// SPDX-License-Identifier: Apache-2.0
// From pixels to the kernel's rays: picture space to lattice space, exaggeration and earth
// curvature.
#pragma once

#include "kernel/layout/layout.h"
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
    Ray rayThrough(double px, double py) const { return latticeRay(camera_.rayThrough(px, py)); }
    Ray latticeRay(const WorldRay& ray) const;
    /// Place on a ray, in picture space.
    WorldPoint pointAt(const Ray& ray, double t) const;

    const Camera& camera() const { return camera_; }
    const Affine2& worldFromLattice() const { return worldFromLattice_; }
    double exaggeration() const { return exaggeration_; }
    double bend() const { return bend_; }

private:
    Camera camera_;
    Affine2 worldFromLattice_;
    double exaggeration_, bend_;
};

/// Picture rectangle worked on at once.
struct ImageTile {
    int x = 0, y = 0, width = 0, height = 0;
    size_t pixelCount() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
};

}  // namespace terray
