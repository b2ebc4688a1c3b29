// SPDX-License-Identifier: Apache-2.0
// Sun shadows by sharing: one sweep of the drawn tiles along the sun bounds, for every place where
// a ray may cross a row of posts, the height above which it is free and below which it is caught.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "kernel/layout/layout.h"
#include "kernel/trace.h"

namespace terray {

/// All rays to one sun: translates of one parabola in lattice space. Their slope at a place is
/// rise + riseI i + riseJ j, where riseI dx + riseJ dy = 2 bend (a ray that goes on is such a ray).
struct SunDirection {
    double dx = 0, dy = 0, bend = 0;
    double rise = 0, riseI = 0, riseJ = 0;

    double slopeAt(double i, double j) const { return rise + riseI * i + riseJ * j; }
    Ray rayFrom(double i, double j, double z) const {
        return {i, j, z, dx, dy, slopeAt(i, j), bend};
    }
    bool operator==(const SunDirection&) const = default;
};

/// A tile's axes as the sun sees them: rows are crossed one by one on the way to the sun, while the
/// column grows by `shear` (0..1) a row. A tile's place (x, y) is mirrored, then transposed.
struct SunAxes {
    bool transposed = false, mirroredX = false, mirroredY = false;
    double shear = 0;
};

/// A drawn tile as the lanes want it (kernel/simd/shadow_lanes.h).
struct SweptTile {
    const void* posts = nullptr;  ///< null: not swept
    const uint32_t* entries = nullptr;
    float postsZ = 0, postsStep = 0;  ///< heights relative to the sweep's anchor
    float perRow = 0;                 ///< t from row to row
    float error = 0;                  ///< height error of a float ray and a cell, metres
    float errorPerRow = 0;            ///< what a row's way adds to it
    float rise = 0, risePerColumn = 0,
          risePerRow = 0;           ///< of a ray, metres a row, in the sun's axes
    int32_t columns = 0, rows = 0;  ///< cells up to which a walk may go: whole cells of the terrain
    /// Who goes on in the tile of the same mip behind the far row or column: its slot, or one of
    /// the two below.
    uint32_t ahead = kNoSlot, aside = kNoSlot;
};
constexpr uint32_t kUnlikeTile = kNoSlot;         ///< another mip, or nothing drawn
constexpr uint32_t kBeyondTerrain = kNoSlot - 1;  ///< the terrain ends there

/// Rows of posts between rows of bounds, rows of bounds in a tile, and entries a row: strips of one
/// cell's width along the sun.
constexpr int kSweepStep = 2;
constexpr int kSweepRows = kSlotCells / kSweepStep;
constexpr int kSweepStride = 520;
constexpr int kSweepEntries = kSweepRows * kSweepStride;
/// An entry is asked on the way to its row: the low half is a code of `caught` there, rounded down
/// (0: unknown), the high half of `free` kSweepStep rows before, rounded up.
constexpr uint32_t kUnknownFree = 0xFFFFu;
/// Rays gain at least this share of their rise on ground that counts as facing the sun.
constexpr float kGainOnFacing = 0.125f;

/// Shadow heights of a cut under one sun. Derived data: valid while the same tiles are drawn.
/// const-shared.
class SunSweep {
public:
    /// Sweeps all drawn tiles, on all cores; the result does not depend on their number. Null where
    /// there is nothing to gain: constant surface, sun overhead, or a ray that would descend.
    static std::shared_ptr<const SunSweep> make(const TerrainCut& cut, const SunDirection& sun);

    /// True if the sweep holds for this cut (the same tiles of the same pool) and this sun.
    bool fits(const TerrainCut& cut, const SunDirection& sun) const;

    const SunDirection& sun() const { return sun_; }
    uint64_t bytes() const { return bytesFor(drawn_.size()); }
    static uint64_t bytesFor(size_t tiles) { return uint64_t{4} * kSweepEntries * tiles; }

    /// Bounds of the shadow height for rays in the strip that crosses row `row` (a multiple of
    /// kSweepStep, 2..512, in the sun's axes) of a drawn tile at `column` (0..512). `free`: where
    /// they cross row - kSweepStep; who is higher there, and above the ground from some place
    /// before `row` on, meets nothing from there on. `caught`: where they cross `row`; who is
    /// lower, and was above the ground up to here, meets the ground. For tests.
    struct Bounds {
        double free, caught;
    };
    Bounds boundsAt(uint32_t slot, int row, double column) const;

    // What the lanes read.
    const SunAxes& axes() const { return axes_; }
    const SweptTile& tile(uint32_t slot) const { return tiles_[slot]; }
    const uint32_t* entries() const { return entries_.get(); }
    float anchorZ() const { return anchorZ_; }
    float codeZ() const { return codeZ_; }        ///< relative to the anchor
    float codeStep() const { return codeStep_; }  ///< metres a code
    double slopeTolerance() const { return slopeTolerance_; }

private:
    friend class SunSweeper;
    SunSweep() = default;

    SunDirection sun_;
    SunAxes axes_;
    const void* posts_ = nullptr;
    std::vector<uint32_t> drawn_;   ///< slots, in the order of the directory
    std::vector<SweptTile> tiles_;  ///< per slot
    struct Free {
        void operator()(uint32_t* entries) const { std::free(entries); }
    };
    static std::unique_ptr<uint32_t[], Free> allocate(size_t count);

    std::unique_ptr<uint32_t[], Free> entries_;
    float anchorZ_ = 0, codeZ_ = 0, codeStep_ = 1;
    double slopeTolerance_ = 0;
};

/// The first entry of a row is that of strip firstStrip(row): the strip over column c at this row
/// is floor(c - shear row). In float, so that lanes compute the same.
inline float firstStrip(float shear, float row) { return std::floor(-(shear * row)) - 2.0f; }

/// Slots of the drawn tiles of a cut, in the order of the directory.
std::vector<uint32_t> drawnSlots(const TerrainCut& cut);

/// Places on the ground that ask whether the sun reaches them: those of kSunAsks hits that stand
/// side by side, one array a quantity.
constexpr int kSunAsks = 64;
struct alignas(64) SunAsks {
    uint32_t tile[kSunAsks];  ///< of the hit; kNoSlot: does not ask
    int32_t cell[kSunAsks];
    float u[kSunAsks], v[kSunAsks];
    float z[kSunAsks];  ///< true metres
    uint64_t strange =
        0;  ///< bits of hits, from below or on walls, that ask though tile is kNoSlot

    void clear() {
        std::fill_n(tile, kSunAsks, kNoSlot);
        strange = 0;
    }
    bool asks(int k) const { return tile[k] != kNoSlot || (strange >> k & 1) != 0; }
    void withdraw(int k) {
        tile[k] = kNoSlot;
        strange &= ~(uint64_t{1} << k);
    }
    /// A hit asks, from height z.
    void ask(int k, const Hit& hit, float height) {
        const bool plain = hit.flags == kHitValid;
        tile[k] = plain ? hit.tile : kNoSlot;
        cell[k] = static_cast<int32_t>(hit.cell);
        u[k] = hit.u;
        v[k] = hit.v;
        z[k] = height;
        if (!plain) strange |= uint64_t{1} << k;
    }
};

/// Shadow counters: how rays were decided.
struct ShadowCounters {
    uint64_t rays = 0;
    uint64_t dark = 0;
    uint64_t cells = 0;    ///< walked, the hit cells included
    uint64_t cast = 0;     ///< handed on to `occluded`
    TraceCounters traced;  ///< of those
};

/// The ray of a hit to a sun, from height z.
Ray sunRay(const TerrainCut& cut, const SunDirection& sun, const Hit& hit, float z);

/// dark[k] = 1 exactly where `occluded` says so of the ray sunRay(hits[k], z) to the sweep's sun,
/// for all that ask; else 0. `dark`: kSunAsks for each of `asks`.
void shadows(const TerrainCut& cut, const SunSweep& sweep, std::span<const Hit> hits,
             std::span<const SunAsks> asks, std::span<uint8_t> dark, ShadowCounters& counters);

}  // namespace terray
