// SPDX-License-Identifier: Apache-2.0
// Warping on the fly: a north-up lattice in the working CRS whose posts are interpolated in the
// samples of a raster in another CRS.
#pragma once

#include <memory>
#include <string>

#include "geo/frame.h"
#include "math/affine.h"
#include "raster/raster_header.h"
#include "tile/height_source.h"

namespace terray {

/// How lattice places become places in the raster. Sample (i, j) is at dataFromSample (i, j).
struct WarpPlan {
    RasterHeader header;
    std::string dataCrs, workingCrs;
    Affine2 dataFromSample;         ///< data CRS units
    Vec2 dataCentre;                ///< middle of the raster's extent
    int64_t columns = 0, rows = 0;  ///< of the lattice
    Affine2 worldFromLattice;

    Result<GeoFrame> makeFrame() const;
};

/// Completes a plan that has all but the lattice: posts as far apart as the raster's finer ground
/// size at its centre, covering its pixels. Error Input if the extent cannot be mapped.
Result<void> planLattice(WarpPlan& plan);

/// Posts are bicubic (Catmull-Rom) where all 16 samples around are valid; beside holes and at the
/// rim bilinear over the valid ones of 4; holes where the nearest sample is one or the place lies
/// outside the raster's pixels. A post has the same value in every window that is read. Uses all
/// cores.
Result<std::unique_ptr<HeightReader>> makeWarpReader(const WarpPlan& plan);

}  // namespace terray
