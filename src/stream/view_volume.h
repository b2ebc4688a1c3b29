// SPDX-License-Identifier: Apache-2.0
// What a picture may show of a box of ground, and how finely; never underestimated.
#pragma once

#include <vector>

#include "math/affine.h"
#include "stream/cut.h"
#include "stream/selector.h"

namespace terray {

/// const-shared.
class ViewVolume {
public:
    /// Borrows the selector.
    ViewVolume(const Selector& selector, const Affine2& worldFromLattice, const Camera& camera,
               const CutOptions& options);

    /// Something within the box and between true heights may be in the picture.
    bool mayShow(const LatticeBox& box, Selector::Heights heights) const;
    /// The finest mip whose posts shading reads anywhere in the block; a large number if it is not
    /// in the picture.
    int finestMip(const LatticeBox& box, const BlockBounds& block) const;

private:
    /// Inside where dot(normal, point - eye) + offset >= 0.
    struct Plane {
        Vec3 normal;
        double offset = 0;
    };
    const Selector& selector_;
    Affine2 map_;
    WorldPoint eye_;
    std::vector<Plane> planes_;
    double cellMetres_;    ///< the longer side of a cell
    double pixelAngle_;    ///< the least that a sample covers, radians; ortho: 0
    double sampleMetres_;  ///< ortho: metres that a sample covers
};

}  // namespace terray
