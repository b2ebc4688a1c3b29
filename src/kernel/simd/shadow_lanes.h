// SPDX-License-Identifier: Apache-2.0
// Shadow rays that walk from their hit until the bounds of a sun sweep decide, in SIMD lanes.
// Compiled once per SIMD target.
#pragma once

#include <cstdint>

#include "kernel/sweep/sun.h"

namespace terray::simd {

constexpr int kShadowRays = 256;
constexpr int kShadowPad = 16;  ///< a whole packet of lanes may be read behind the last ray

enum ShadowResult : int32_t {
    kShadowGoesOn = 0,
    kShadowDark = 1,
    kShadowLit = 2,
    kShadowUndecided = 3,  ///< for another tracer
    kShadowAhead = 4,      ///< leaves the tile through its far row
    kShadowAside = 5,      ///< leaves the tile through its far column
};

/// Rays of one sun in one tile. Places are the tile's own at the hits, then in the sun's axes.
struct alignas(64) ShadowBlock {
    static constexpr int kSize = kShadowRays + kShadowPad;
    int32_t column[kSize], row[kSize];   ///< cell: x, y at first
    float u[kSize], v[kSize];            ///< place in the cell
    float z[kSize], dz[kSize];           ///< at the hit, relative to the anchor; metres a row
    float crossed[kSize], start[kSize];  ///< rows crossed since the hit; its place in its row
    int32_t result[kSize];
    int32_t source[kSize];  ///< whose ray this is

    void copyRay(size_t to, const ShadowBlock& from, size_t k) {
        column[to] = from.column[k];
        row[to] = from.row[k];
        u[to] = from.u[k];
        v[to] = from.v[k];
        z[to] = from.z[k];
        dz[to] = from.dz[k];
        crossed[to] = from.crossed[k];
        start[to] = from.start[k];
        source[to] = from.source[k];
    }
};

/// Walks the first `count` rays through a tile until each is decided or leaves: `results` by
/// source. `atHits`: the rays stand at their hits, not at the entry of a cell. Those that leave are
/// copied to the end of `leaving`. Returns the number of cells walked.
uint64_t walkShadows(const TerrainCut& cut, const SunSweep& sweep, const SweptTile& tile,
                     ShadowBlock& block, int count, bool atHits, int32_t* results,
                     ShadowBlock& leaving, int& leavingCount);

}  // namespace terray::simd
