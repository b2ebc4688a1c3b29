// SPDX-License-Identifier: Apache-2.0
// Rays to a device and hits from it: single precision in between, double precision at both ends.
#include "kernel/device_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "kernel/exact/exact.h"
#include "kernel/glsl/cpp.h"
#include "kernel/simd/ray_lanes.h"

namespace terray {
namespace {

// One layout on both sides.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(glsl::TileDesc) == sizeof(TileDesc) &&
              offsetof(glsl::TileDesc, bounds) == offsetof(TileDesc, bounds) &&
              offsetof(glsl::TileDesc, x) == offsetof(TileDesc, x) &&
              offsetof(glsl::TileDesc, z0) == offsetof(TileDesc, z0) &&
              offsetof(glsl::TileDesc, zStep) == offsetof(TileDesc, zStep) &&
              offsetof(glsl::TileDesc, boundsZ0) == offsetof(TileDesc, boundsZ0) &&
              offsetof(glsl::TileDesc, boundsStep) == offsetof(TileDesc, boundsStep) &&
              offsetof(glsl::TileDesc, maxDelta) == offsetof(TileDesc, maxDelta) &&
              offsetof(glsl::TileDesc, mipFlags) == offsetof(TileDesc, mipFlags));
static_assert(sizeof(glsl::Square) == sizeof(Square) &&
              offsetof(glsl::Square, maxZ) == offsetof(Square, maxZ) &&
              offsetof(glsl::Square, slot) == offsetof(Square, slot) &&
              offsetof(glsl::Square, state) == offsetof(Square, state));
static_assert(sizeof(glsl::DirectoryLevel) == sizeof(DirectoryLevel) &&
              offsetof(glsl::DirectoryLevel, columns) == offsetof(DirectoryLevel, columns));
static_assert(sizeof(glsl::TraceCut) == sizeof(TraceCut) &&
              offsetof(glsl::TraceCut, anchorZ) == offsetof(TraceCut, anchorZ) &&
              offsetof(glsl::TraceCut, maxSteps) == offsetof(TraceCut, maxSteps));
static_assert(sizeof(glsl::TraceRay) == sizeof(TraceRay) &&
              offsetof(glsl::TraceRay, dx) == offsetof(TraceRay, dx) &&
              offsetof(glsl::TraceRay, tEnd) == offsetof(TraceRay, tEnd) &&
              offsetof(glsl::TraceRay, level) == offsetof(TraceRay, level));
static_assert(sizeof(glsl::RaySlack) == sizeof(RaySlack) &&
              offsetof(glsl::RaySlack, height) == offsetof(RaySlack, height));
static_assert(sizeof(glsl::TraceHit) == sizeof(Hit) &&
              offsetof(glsl::TraceHit, u) == offsetof(Hit, u) &&
              offsetof(glsl::TraceHit, stepsMipFlags) == offsetof(Hit, steps) &&
              offsetof(Hit, mip) == offsetof(Hit, steps) + 2 &&
              offsetof(Hit, flags) == offsetof(Hit, steps) + 3);
static_assert(glsl::kSlotCells == kSlotCells && glsl::kPostStride == kPostStride &&
              glsl::kTileLevels == kTileLevels && glsl::kSlotBounds == int{kSlotBounds} &&
              glsl::kTileMipMask == kTileMipMask && glsl::kNoSlot == kNoSlot &&
              glsl::kEnterAtTop == simd::kEnterAtTop);
static_assert(glsl::kSquareEmpty == kSquareEmpty && glsl::kSquareDrawn == kSquareDrawn &&
              glsl::kSquareDescend == kSquareDescend && glsl::kSquareCovered == kSquareCovered);
static_assert(glsl::kSurfaceBilinear == kSurfaceBilinear &&
              glsl::kSurfaceConstant == kSurfaceConstant &&
              glsl::kSurfaceTriangles == kSurfaceTriangles);
static_assert(glsl::kHitValid == kHitValid && glsl::kHitFromBelow == kHitFromBelow &&
              glsl::kHitStrip == kHitStrip && glsl::kHitUnderSheet == kHitUnderSheet &&
              glsl::kHitPlaceOpen == kHitPlaceOpen && glsl::kHitUncertain == kHitUncertain);

/// A walk takes some hundred steps; one of more is left to double precision, which always ends.
constexpr int32_t kMaxSteps = 20000;

/// Rays whose cell the device knows, but not the place in it.
struct OpenHits {
    RayBatch batch;
    Hit hits[kBatchRays];
    int source[kBatchRays];
    int count = 0;

    void add(const RayBatch& from, int k, const Hit& hit) {
        batch.set(count, from.ray(k));
        hits[count] = hit;
        source[count++] = k;
    }
};

Hit redo(const TerrainCut& cut, const RayBatch& batch, int k, TraceCounters& counters) {
    Ray ray = batch.ray(k);
    ray.tMin = std::max(ray.tMin, batch.clear[k]);
    ++counters.redone;
    return exact::firstHit(cut, ray);
}

}  // namespace

TraceCut traceCutOf(const TerrainCut& cut) {
    const float largest = std::max(std::fabs(cut.minZ), std::fabs(cut.maxZ));
    return {cut.format,
            cut.surface,
            cut.rootLevel,
            cut.cellsX,
            cut.cellsY,
            0.5f * (cut.minZ + cut.maxZ),
            std::max(0.5f * (cut.maxZ - cut.minZ), cut.codeReach) + 1e-3f,
            cut.maxDelta,
            cut.format == glsl::kPostsInt16 ? 0x1p-24f * largest : 0.0f,
            0x1p-23f * largest,
            kMaxSteps};
}

void placeTraceRays(const TerrainCut& cut, RayBatch& batch, int count, int level,
                    std::span<TraceRay> rays) {
    simd::RayBlock b;
    const int padded = (count + 15) / 16 * 16;
    for (int k = count; k < padded; ++k) {
        batch.set(k, batch.ray(0));
        batch.end[k] = -1e300;
    }
    simd::placeRays(cut, batch, b, padded, level);
    for (int k = 0; k < count; ++k) {
        const bool some = b.state[k] != simd::kLaneDone;
        rays[static_cast<size_t>(k)] = {
            b.anchorX[k],
            b.anchorY[k],
            b.fx[k],
            b.fy[k],
            b.dx[k],
            b.dy[k],
            b.z[k],
            b.dz[k],
            b.bend[k],
            some ? b.tEnd[k] : -1.0f,
            some ? static_cast<float>(std::max(batch.begin[k], batch.clear[k])) : 0.0f,
            level};
    }
}

void finishTraceHits(const TerrainCut& cut, RayBatch& batch, int count,
                     std::span<const TraceHit> found, std::span<Hit> hits,
                     TraceCounters& counters) {
    OpenHits open;
    for (int k = 0; k < count; ++k) {
        const auto at = static_cast<size_t>(k);
        Hit hit = std::bit_cast<Hit>(found[at]);
        const auto flags = hit.flags;
        counters.steps += hit.steps;
        hit.flags = flags & (kHitValid | kHitFromBelow | kHitStrip);
        hit.t = static_cast<float>(std::max(batch.begin[k], batch.clear[k]) +
                                   static_cast<double>(hit.t));
        batch.above[k] = (flags & (kHitUnderSheet | kHitFromBelow)) == 0;
        if ((flags & kHitPlaceOpen) != 0 && cut.surface != kSurfaceConstant) {
            open.add(batch, k, hit);
        } else if ((flags & (kHitPlaceOpen | kHitUncertain)) != 0) {
            hit = redo(cut, batch, k, counters);
            counters.steps += hit.steps;
            batch.above[k] = isHit(hit) && cut.hasHoles == 0 && (hit.flags & kHitFromBelow) == 0;
        } else if (!isHit(hit)) {
            const uint16_t steps = hit.steps;
            hit = Hit{};
            hit.steps = steps;
        }
        hits[at] = hit;
    }
    if (open.count != 0) hitsInCells(cut, open.batch, open.count, open.hits);
    for (int k = 0; k < open.count; ++k) {
        const int source = open.source[k];
        Hit hit = open.hits[k];
        if (!isHit(hit)) {
            hit = redo(cut, batch, source, counters);
            counters.steps += hit.steps;
            batch.above[source] =
                isHit(hit) && cut.hasHoles == 0 && (hit.flags & kHitFromBelow) == 0;
        }
        hits[static_cast<size_t>(source)] = hit;
    }
    counters.rays += static_cast<uint64_t>(count);
    for (int k = 0; k < count; ++k) counters.hits += isHit(hits[static_cast<size_t>(k)]) ? 1u : 0u;
}

}  // namespace terray
