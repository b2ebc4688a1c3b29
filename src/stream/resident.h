// SPDX-License-Identifier: Apache-2.0
// A terrain in memory: tiles in one pool, ready for any cut. All of them, or those that the frames
// want of a terrain that is larger than memory (streamer.h).
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "kernel/layout/layout.h"
#include "tile/height_source.h"
#include "tile/tile_source.h"

namespace terray {

class Streamer;

/// Figures of a build.
struct BuildStats {
    double loadMs = 0, buildMs = 0;
    uint64_t residentBytes = 0;
    uint64_t holes = 0;  ///< posts of mip 0 without a height
};

/// Tiles of all mips of a terrain in one contiguous pool. const-shared once built.
class ResidentTerrain {
public:
    /// Memory the terrain will take; known from the header alone.
    static uint64_t requiredBytes(const TerrainInfo& info);
    /// Reads the source once, builds mips, pyramids and errors on all cores. Error Input when
    /// requiredBytes exceeds `memoryBytes`; passes on read errors; Interrupted.
    static Result<std::unique_ptr<ResidentTerrain>> build(const HeightSource& source,
                                                          uint64_t memoryBytes, BuildStats& stats);
    /// The same from finished tiles: nothing is fitted or measured again.
    static Result<std::unique_ptr<ResidentTerrain>> build(const TileSource& source,
                                                          uint64_t memoryBytes, BuildStats& stats);
    /// Tiles on demand: at most `poolBytes` at a time. The mips from `firstKept` on are read now
    /// and stay. Error Input if they do not fit.
    static Result<std::unique_ptr<ResidentTerrain>> stream(std::unique_ptr<TileSource> source,
                                                           int firstKept, uint64_t poolBytes,
                                                           BuildStats& stats);
    ~ResidentTerrain();

    const TerrainInfo& info() const { return info_; }  ///< minZ, maxZ are exact
    int mipCount() const;
    uint64_t residentBytes() const;    ///< of all slots and tables
    uint32_t slotOf(TileId id) const;  ///< kNoSlot outside, or if it is not resident
    /// Who brings tiles; null if all are resident.
    Streamer* streamer() const { return streamer_.get(); }
    std::span<const BlockBounds> blocks(uint32_t slot) const;  ///< 64, row-major

    /// A cut with every square undrawn but page table, pools and sizes filled: base of selectCut().
    struct Pool;
    const Pool& pool() const { return *pool_; }

private:
    ResidentTerrain();
    static Result<std::unique_ptr<ResidentTerrain>> make(const TerrainInfo& info,
                                                         uint64_t memoryBytes);
    TerrainInfo info_;
    std::unique_ptr<TileSource> source_;
    std::unique_ptr<Pool> pool_;
    std::unique_ptr<Streamer> streamer_;  ///< last: ends before what it writes to
};

}  // namespace terray
