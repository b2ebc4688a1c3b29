// SPDX-License-Identifier: Apache-2.0
// A whole terrain as one small grid: the mip that has few enough posts, for surveys and sky light.
#pragma once

#include <vector>

#include "kernel/layout/layout.h"
#include "tile/terrain_info.h"

namespace terray {

struct Overview {
    int mip = 0, width = 0, height = 0;
    std::vector<float> heights;  ///< metres, row by row; NaN for holes
};

int overviewMip(const TilingScheme& scheme, int64_t mostPosts);

/// The finest mip of at most `mostPosts` posts (or the coarsest one).
Overview makeOverview(const TerrainCut& cut, const TilingScheme& scheme, int64_t mostPosts);

/// Mean slope (rise over run) between neighbouring posts; 0 if there are none.
double meanSlope(const Overview& view, const Affine2& worldFromLattice);

}  // namespace terray
