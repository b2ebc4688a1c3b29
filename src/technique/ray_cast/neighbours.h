// SPDX-License-Identifier: Apache-2.0
// How the rays of neighbouring pixels stand to each other: between which rays of the row below a
// ray stands, and what ground could hide between them (docs/traversal.md).
#pragma once

#include <optional>

#include "kernel/beam.h"
#include "kernel/columns.h"
#include "view/ray_frame.h"

namespace terray {

/// Pixels x0 ... x1 of rows y0 ... y1, at sample places.
struct PixelBlock {
    double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

struct Neighbours {
    bool upwards = true;  ///< rows further up in the picture look higher
    /// Columns to look aside: the ray stands between two of these of the row below it.
    int left = 0, right = 0;
    /// Only ground whose slope falls off by so many metres a cell can stand between two rays of one
    /// row and reach up to the next row, with w in metres ahead; infinite: none can.
    BeamWalk::Sharp sharp;
};

/// `side`: -1 where the rays look backwards (RayFrame's "ahead"). Nothing if the rows do not stand
/// one over the other, or too far aside.
std::optional<Neighbours> neighboursOf(const RayFrame& rays, const PixelBlock& block, int side);

}  // namespace terray
