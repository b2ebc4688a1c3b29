// SPDX-License-Identifier: Apache-2.0
// Shadow rays that walk from their hit until the bounds of a sun sweep decide, in SIMD lanes.
// Compiled once per SIMD target.
#pragma once

#include <cstdint>

#include "kernel/sweep/sun.h"

namespace terray::simd {

constexpr int kShadowRays = 256;
constexpr int kShadowPad = 16;  ///< a whole packet of lanes may be read behind the last ray

/// What is known of a ray: written for dark and undecided ones only.
enum ShadowVerdict : uint8_t {
    kShadowLit = 0,
    kShadowDark = 1,
    kShadowUndecided = 2,  ///< for another tracer
};

/// A ray of one sun in one tile. Places are in the sun's axes.
struct ShadowRay {
    int32_t column, row;  ///< cell
    float u, v;           ///< place in the cell
    float z, dz;          ///< at the hit, relative to the anchor; metres a row
    float way;            ///< rows from the hit to where v is 0
    int32_t source;       ///< whose ray this is
};

struct alignas(64) ShadowBlock {
    static constexpr int kSize = kShadowRays + kShadowPad;
    int32_t column[kSize], row[kSize];
    float u[kSize], v[kSize];
    float z[kSize], dz[kSize];
    float way[kSize];
    int32_t source[kSize];
    int32_t bounds[kSize];  ///< what the bounds ahead say (shadow_lanes-inl.h); 0: not yet asked
    int count = 0;

    ShadowRay ray(int k) const {
        return {column[k], row[k], u[k], v[k], z[k], dz[k], way[k], source[k]};
    }
    void add(const ShadowRay& ray) {
        const int k = count++;
        column[k] = ray.column;
        row[k] = ray.row;
        u[k] = ray.u;
        v[k] = ray.v;
        z[k] = ray.z;
        dz[k] = ray.dz;
        way[k] = ray.way;
        source[k] = ray.source;
        bounds[k] = 0;
    }
};

/// Rays that have come to the border of a tile: through its far row, through its far column.
struct ShadowLeaving {
    ShadowBlock ahead, aside;
};

/// Asks the bounds for those of a batch whose hits lie in tile `slot`: verdicts of those that this
/// decides, by number (the batch's first is `first`); the others are added to `hits`, which has
/// room for kSunAsks. Returns how many there were.
int startShadows(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, const SunAsks& asks,
                 int first, ShadowBlock& hits, uint8_t* verdicts);

/// Takes rays through the cells of their hits: to their verdicts, to `block`, which has room for
/// them, or to `leaving`, which is empty. Less than a packet may stay, unless `all` are to leave.
/// Returns the number of cells.
uint64_t leaveHits(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, bool all,
                   ShadowBlock& hits, ShadowBlock& block, ShadowLeaving& leaving,
                   uint8_t* verdicts);

/// Walks the rays of a block through tile `slot` until all but `rest` are decided or have left: the
/// last few would leave most lanes idle. Returns the number of cells walked.
uint64_t walkShadows(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, int rest,
                     ShadowBlock& block, ShadowLeaving& leaving, uint8_t* verdicts);

}  // namespace terray::simd
