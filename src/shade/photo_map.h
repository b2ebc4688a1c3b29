// SPDX-License-Identifier: Apache-2.0
// From ground to photo: which pixels a sample covers, and how they look in a lit picture.
#pragma once

#include "math/affine.h"
#include "shade/ground.h"
#include "shade/photo_filter.h"

namespace terray {

/// const-shared.
class PhotoMap {
public:
    /// `share`: width of a sample, in pixels of the picture.
    PhotoMap(const Affine2& worldFromLattice, const Affine2& worldFromPixel, double share);
    void place(const GroundBatch& ground, PhotoFeet& feet) const;

private:
    double x0_, xi_, xj_, y0_, yi_, yj_;     ///< pixel from lattice
    float xEast_, xNorth_, yEast_, yNorth_;  ///< pixels a metre, times the share
};

/// `own` becomes what the photo shows whatever the light; `albedo`, the ground where there is no
/// photo, becomes what the light falls on: `relief` 0..1 of the photo, and the ground around it.
void showPhoto(const PhotoBatch& photo, float relief, FloatsRgb& own, FloatsRgb& albedo);

}  // namespace terray
