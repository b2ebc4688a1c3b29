// SPDX-License-Identifier: Apache-2.0
// Bringing the tiles that pictures, places and rays need, where not all are resident.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "kernel/height.h"
#include "stream/cut.h"
#include "stream/resident.h"
#include "terray/options.h"

namespace terray {

struct TileFigures {
    uint64_t wanted = 0, loaded = 0, evicted = 0;
    uint64_t absent = 0;  ///< wanted, but on their way or unreadable
    uint64_t bytesRead = 0;
    double latencyMs = 0, latencyP99Ms = 0;  ///< of all tiles since the start
};

/// And what the picture wants, for selectCut(); empty where all tiles are resident.
struct BroughtTiles {
    TileFigures figures;
    std::vector<TileId> wanted;
};

/// Brings all tiles that a picture wants, or, without waitForTiles, those that have arrived, and
/// asks for those that the picture of `soon` will want, as far as there is room. Where
/// they do not fit, asks for less in `cut`: first of the relief that shading shows, then of the
/// tolerance, and says so. Error: Input when even that does not fit; Failed when a tile cannot be
/// read and none may be missing; Interrupted. `steps`: how much less was asked for; kept from one
/// picture that does not wait to the next.
Result<BroughtTiles> bringTiles(const ResidentTerrain& terrain, const Camera& camera,
                                const std::optional<Camera>& soon, const RenderOptions& options,
                                int& steps, CutOptions& cut);

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
