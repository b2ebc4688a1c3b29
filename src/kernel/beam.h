// SPDX-License-Identifier: Apache-2.0
// A bundle of rays at once: how far all of them surely stay above the surface.
#pragma once

#include "kernel/layout/layout.h"

namespace terray {

/// Rays between four corner rays. All share the parameter w, and at any w every ray of the bundle
/// lies inside the quadrilateral of the corners, widened by bulge * w cells (curved fronts:
/// panoramas).
struct Beam {
    Ray corners[4];
    double bulge = 0;
};

/// Every ray of the bundle is above the drawn surface for all w in [0, w]; `level` is the size of
/// block (2^level mip-0 cells) at which nothing more could be said. w = 0 is always true.
struct BeamStart {
    double w = 0;
    int level = kMaxLevels;
};
BeamStart beamStart(const TerrainCut& cut, const Beam& beam);

}  // namespace terray
