// SPDX-License-Identifier: Apache-2.0
// The sky-light field: how much of the sky each place of the terrain sees.
#pragma once

#include <cstdint>
#include <vector>

#include "shade/batch.h"
#include "shade/overview.h"

namespace terray {

/// const-shared once made.
class SkyLight {
public:
    /// Sweeps the overview; `exaggeration` scales its heights.
    SkyLight(Overview overview, const Affine2& worldFromLattice, double exaggeration);

    /// Open share of the sky 0..1 at a place of the mip-0 lattice, averaged over about `footprint`
    /// mip-0 cells: bilinear between posts, linear between mips.
    float at(double i, double j, float footprint) const;
    /// The same at kBatch places.
    void at(const Places& places, const Floats& footprint, Floats& open) const;

private:
    /// The field and its means over 2 x 2, 4 x 4 ... posts; post (i, j) of a mip stands in the
    /// middle of the posts it is the mean of.
    struct Mip {
        std::vector<uint16_t> open;
        int width = 0, height = 0;
        double scale = 1, shift = 0;  ///< post = place * scale + shift
        float at(double i, double j) const;
    };
    static Mip halve(const Mip& fine);
    void readMips(const Ints& mip, const Places& places, Floats& open) const;

    int finest_ = 0;  ///< mip of the terrain that the field's finest is made of
    std::vector<Mip> mips_;
    std::vector<const uint16_t*> posts_;  ///< of each mip
};

}  // namespace terray
