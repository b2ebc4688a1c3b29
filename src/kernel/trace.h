// SPDX-License-Identifier: Apache-2.0
// Ray queries on a cut: first hits and shadow tests, for any number of rays, exact
// (docs/precision.md). Dispatches at run time to the best SIMD target of the machine (kernel/simd).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kernel/layout/layout.h"
#include "kernel/ray_batch.h"

namespace terray {

/// Work done, summed over calls by the caller.
struct TraceCounters {
    uint64_t rays = 0, hits = 0, steps = 0;
    uint64_t redone =
        0;  ///< rays whose float result was uncertain and that were traced again in double
    uint64_t columns = 0;  ///< rays that began where the ray below had hit (kernel/columns.h)
    uint64_t beams = 0;    ///< rays that began where a bundle of rays ended (kernel/beam.h)

    void add(const TraceCounters& c) {
        rays += c.rays;
        hits += c.hits;
        steps += c.steps;
        redone += c.redone;
        columns += c.columns;
        beams += c.beams;
    }
};

/// First hit of every ray. hits.size() == rays.size(). Any order of rays is right; neighbours that
/// look the same way are fast. Thread rule: const-shared cut, confined spans.
void firstHits(const TerrainCut& cut, std::span<const Ray> rays, std::span<Hit> hits,
               TraceCounters& counters);

/// The first `count` rays of a batch whose fields are all set, with a head start (kernel/beam.h):
/// from batch.clear[k] on, blocks larger than 2^level cells are of no use. Hits do not depend on
/// it. Narrows batch.begin and end, sets batch.above.
void firstHits(const TerrainCut& cut, RayBatch& batch, int count, int level, std::span<Hit> hits,
               TraceCounters& counters);

/// The same for rays that are known to come from above and to hit first in the cell of hits[k]:
/// fixes distance and place. Without kHitValid afterwards: double precision sees no hit there. Not
/// for constant surfaces.
void hitsInCells(const TerrainCut& cut, RayBatch& batch, int count, std::span<Hit> hits);

/// Shadow tests: occluded[k] = 1 where the ray leaving hits[k] (a point on the drawn surface) meets
/// the surface again at t > 0. rays[k] has its origin at the hit's place; the known root t = 0 is
/// divided out of the hit cell's quadratic, so no bias is needed. Invalid hits give 0. A ray that
/// starts into the ground is occluded at once: on the upper side of the sheet when it descends
/// below the hit cell's tangent, on the lower side (kHitFromBelow) when it rises above it.
void occluded(const TerrainCut& cut, std::span<const Hit> hits, std::span<const Ray> rays,
              std::span<uint8_t> occluded, TraceCounters& counters);

/// The SIMD targets of this machine ("AVX3", "AVX2", ...), best first, and the one in use.
std::vector<std::string> simdTargets();
std::string activeSimdTarget();
/// Uses one target only (tests, bench); an empty name restores the best. False if it is not
/// available.
bool setSimdTarget(const std::string& name);

}  // namespace terray
