// SPDX-License-Identifier: Apache-2.0
// Which tile is drawn where, for a whole frame: level of detail by stored error bounds
// (docs/lod.md).
#pragma once

#include <optional>
#include <vector>

#include "kernel/layout/layout.h"
#include "math/affine.h"
#include "stream/resident.h"
#include "view/camera.h"

namespace terray {

/// Sun direction (towards the sun) at the terrain's centre, true world axes; for shadow bounds.
struct SunBound {
    Vec3 towardsSun{0, 0, 1};
};

struct CutOptions {
    double tolerancePx = 2.0 / 3.0;  ///< 0: mip 0 everywhere
    double exaggeration = 1;         ///< camera is in picture space
    double bend = 0;                 ///< c of the surface's bent rays
    SurfaceKind surface = kSurfaceBilinear;
    std::optional<SunBound> sun;  ///< receiver-based bound for what casts shadows
};

/// A cut that owns its directory; movable only, because the cut points into it. const-shared.
class FrameCut {
public:
    FrameCut() = default;
    FrameCut(FrameCut&&) = default;
    FrameCut& operator=(FrameCut&&) = default;

    const TerrainCut& cut() const { return cut_; }
    /// Drawn tiles per mip, for statistics.
    const std::vector<uint64_t>& tilesPerMip() const { return tilesPerMip_; }

private:
    friend FrameCut selectCut(const ResidentTerrain&, const Camera&, const CutOptions&);
    friend FrameCut finestCut(const ResidentTerrain&, SurfaceKind);
    std::vector<Square> squares_;
    std::vector<uint64_t> tilesPerMip_;
    TerrainCut cut_;
};

/// Per tile: coarsest mip whose error, seen from the eye, stays below tolerance / 1.5 in every
/// block.
FrameCut selectCut(const ResidentTerrain& terrain, const Camera& camera, const CutOptions& options);

/// Mip 0 everywhere: queries, tests.
FrameCut finestCut(const ResidentTerrain& terrain, SurfaceKind surface);

}  // namespace terray
