// SPDX-License-Identifier: Apache-2.0
// Bringing the tiles that pictures, places and rays need, where not all are resident.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "kernel/height.h"
#include "stream/cut.h"
#include "stream/resident.h"

namespace terray {

/// Brings all tiles that a picture wants. Where they do not fit, asks for less in `options`: first
/// of the relief that shading shows, then of the tolerance, and says so. Error Input when even that
/// does not fit, or a tile cannot be read; Interrupted.
Result<void> bringTiles(const ResidentTerrain& terrain, const Camera& camera, CutOptions& options);

/// The finest surface at single places. confined; while it is used nobody else may bring tiles, or
/// it brings its own again.
class FinestGround {
public:
    explicit FinestGround(const ResidentTerrain& terrain);
    /// Lattice place. Where the tile cannot be read (which is said) the finest resident one.
    SurfaceCell cellAt(double i, double j);

private:
    const ResidentTerrain& terrain_;
    FrameCut cut_;
    uint64_t version_ = 0;
};

/// First hits on the finest surface, of rays that may pass over more tiles than there is room for:
/// front to back, a few tiles at a time. `found(k, cut, hit)` is called at once for each ray k that
/// hits; cut and hit are gone afterwards. Error Input if a tile cannot be read; Interrupted.
Result<void> firstHitsFar(
    const ResidentTerrain& terrain, SurfaceKind surface, std::span<const Ray> rays,
    const std::function<Result<void>(size_t, const TerrainCut&, const Hit&)>& found);

}  // namespace terray
