// SPDX-License-Identifier: Apache-2.0
// The sky-light field: how much of the sky each place of the terrain sees.
#pragma once

#include <cstdint>
#include <vector>

#include "shade/overview.h"

namespace terray {

/// const-shared once made.
class SkyLight {
public:
    /// Sweeps the overview; `exaggeration` scales its heights.
    SkyLight(Overview overview, const Affine2& worldFromLattice, double exaggeration);

    /// Open share of the sky 0..1 at a place of the mip-0 lattice, bilinear between posts.
    float at(double i, double j) const;

private:
    std::vector<uint16_t> open_;
    int width_ = 0, height_ = 0;
    double scale_ = 1;
};

}  // namespace terray
