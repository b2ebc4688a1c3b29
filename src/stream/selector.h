// SPDX-License-Identifier: Apache-2.0
// The error selector: may a block of a mip stand in for mip 0, as seen from the eye? (docs/lod.md)
#pragma once

#include <optional>

#include "math/affine.h"
#include "stream/cut.h"

namespace terray {

/// A rectangle of the lattice, in posts of mip 0.
struct LatticeBox {
    double i0 = 0, j0 = 0, i1 = 0, j1 = 0;
};

/// Judges blocks for one frame. const-shared.
class Selector {
public:
    /// minZ: the terrain's lowest height, where shadows end.
    Selector(const Affine2& worldFromLattice, double minZ, const Camera& camera,
             const CutOptions& options);
    /// True if what the block draws lies within the tolerance of mip 0.
    bool servesInView(const BlockBounds& block, const LatticeBox& box) const;
    /// True if it does not, by the whole of the tolerance and not the share left to it here.
    bool missesTolerance(const BlockBounds& block, const LatticeBox& box) const {
        return viewShift(block, box) > allowedShadow_;
    }
    /// True if the shadows of what it draws do.
    bool servesInShadows(const BlockBounds& block, const LatticeBox& box) const;

    struct Heights {
        double low, high;
    };
    /// Of the block and of mip 0 under it; low > high if it has no cells.
    Heights trueHeights(const BlockBounds& block) const;
    /// Ground and heights where edges of the block's shadows may fall; low > high: nowhere.
    Heights shadowed(const BlockBounds& block, LatticeBox& box) const;
    /// True heights within a box as the camera sees them: exaggerated, lowered by the curvature.
    Heights pictureHeights(Heights heights, const LatticeBox& box) const;
    /// Squared metres on the ground from the eye, not overestimated.
    double groundDistance2(const LatticeBox& box) const { return distance2(box, eye_); }

private:
    struct Shadows {
        Vec2 away{0, 0};       ///< unit, from the sun
        double cotangent = 0;  ///< of the sun's elevation
        double penumbra = 0;   ///< metres of height error hidden by the penumbra, a metre of ground
    };
    double pixels(double metres, double distance) const;
    double errorOf(const BlockBounds& block) const;
    double viewShift(const BlockBounds& block, const LatticeBox& box) const;
    double shadowLength(double error, double top) const;
    double distance2(const LatticeBox& box, LatticePoint from) const;
    double farthest2(const LatticeBox& box) const;
    double distanceToSweep2(const LatticeBox& box, Vec2 sweep) const;
    double length2(double di, double dj) const {
        return di * di * g11_ + 2 * di * dj * g12_ + dj * dj * g22_;
    }

    Affine2 worldFromLattice_;
    double g11_, g12_, g22_;  ///< metres of lattice steps: their scalar products
    LatticePoint eye_;
    double eyeZ_, minZ_;
    double focal_;                    ///< pixels a radian at the picture's edge; ortho: 0
    double pixelsPerMetre_;           ///< ortho; else 0
    double allowed_, allowedShadow_;  ///< pixels
    double exaggeration_, bend_;
    bool bilinear_;
    std::optional<Shadows> shadows_;
};

}  // namespace terray
