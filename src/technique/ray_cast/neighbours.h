// SPDX-License-Identifier: Apache-2.0
// How the rays of neighbouring pixels stand to each other: between which rays of the row below a
// ray stands, and what ground could hide between them (docs/traversal.md).
#pragma once

#include <optional>

#include "kernel/beam.h"
#include "kernel/ray_terms.h"
#include "view/ray_frame.h"

namespace terray {

/// Pixels x0 ... x1 of rows y0 ... y1, at sample places.
struct PixelBlock {
    double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

struct Neighbours {
    bool upwards = true;  ///< rows further up in the picture look higher
    int rows = 1;         ///< the row that is meant is so many rows below
    /// Columns aside, to the right: the ray stands between two of these of that row.
    int first = 0, last = 0;
    int left() const { return first < 0 ? -first : 0; }
    int right() const { return last > 0 ? last : 0; }
    /// Only ground whose slope falls off by so many metres a cell can stand between two rays of
    /// that row and reach up to this one, with w in metres ahead; infinite: none can.
    BeamWalk::Sharp sharp;
};

/// `side`: -1 where the rays look backwards (RayFrame's "ahead"). Nothing if the rows do not stand
/// one over the other, or too far aside.
std::optional<Neighbours> neighboursOf(const RayFrame& rays, const PixelBlock& block, int side,
                                       int rows);

/// How many columns aside of the ray one row below a ray stands; infinite: not over it.
double asideAt(const RayFrame& rays, double px, double py);

}  // namespace terray
