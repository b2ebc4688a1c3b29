// SPDX-License-Identifier: Apache-2.0
// Which tile is drawn where, for a whole frame: level of detail by stored error bounds
// (docs/lod.md).
#pragma once

#include <optional>
#include <span>
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
    double sampleShare = 1;       ///< of a pixel's width that one sample of shading covers
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
    /// Tiles that are drawn because finer ones are not resident: 0 unless tiles are late.
    uint64_t standIns() const { return standIns_; }
    /// The hit lies on a block that misses the tolerance, for want of a finer tile.
    bool isLate(const Hit& hit) const {
        if (lateBlocks_.empty()) return false;
        const uint32_t block = (cellY(hit) / kBlockCells) * kTileBlocks + cellX(hit) / kBlockCells;
        return (lateBlocks_[hit.tile] >> block & 1u) != 0;
    }
    bool mayBeLate() const { return !lateBlocks_.empty(); }

private:
    friend FrameCut selectCut(const ResidentTerrain&, const Camera&, const CutOptions&,
                              std::span<const TileId>);
    friend FrameCut finestCut(const ResidentTerrain&, SurfaceKind);
    friend FrameCut cutOf(const ResidentTerrain&, SurfaceKind, std::span<const TileId>);
    std::vector<Square> squares_;
    std::vector<uint64_t> tilesPerMip_;
    uint64_t standIns_ = 0;
    std::vector<uint64_t> lateBlocks_;  ///< per slot: TileRule::lateBlocks(); empty if none is
    TerrainCut cut_;
};

/// Per tile: coarsest mip whose error, seen from the eye, stays below tolerance / 1.5 in every
/// block.
/// Where such a tile is not resident a coarser one is drawn. Of what is resident, only
/// wantedTiles() and the tiles that stay are in the cut's page table, so that a picture does not
/// depend on what others have left in memory.
/// `wanted`: those, if they are known; else they are found out.
FrameCut selectCut(const ResidentTerrain& terrain, const Camera& camera, const CutOptions& options,
                   std::span<const TileId> wanted = {});

/// The tiles that selectCut() would like to draw, those that shading reads where they are seen, and
/// all coarser ones over them; coarse ones first, near ones first within a mip.
std::vector<TileId> wantedTiles(const ResidentTerrain& terrain, const Camera& camera,
                                const CutOptions& options);

/// Mip 0 everywhere: queries, tests.
FrameCut finestCut(const ResidentTerrain& terrain, SurfaceKind surface);

/// These tiles, which must be resident and must not overlap, and nothing else.
FrameCut cutOf(const ResidentTerrain& terrain, SurfaceKind surface, std::span<const TileId> tiles);

}  // namespace terray
