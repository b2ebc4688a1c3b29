// SPDX-License-Identifier: Apache-2.0
// Ray queries: double-precision set-up, the float packets of kernel/simd, and a double-precision
// finish that fixes each hit's distance and hands uncertain rays to kernel/exact.
#include "kernel/trace.h"

#include <algorithm>
#include <cmath>

#include "kernel/exact/cell.h"
#include "kernel/exact/exact.h"
#include "kernel/simd/ray_lanes.h"
#include "kernel/simd/trace_block.h"

namespace terray {
namespace {

using simd::kBlockRays;
using simd::RayBlock;

constexpr float kBelowOne = 0.99999994f;
constexpr double kSteep = 1e-30;  ///< a step below this is none: the ray is vertical in that axis

float inverseOf(double step) {
    return std::fabs(step) < kSteep ? 1e30f : static_cast<float>(1.0 / step);
}
float stepOf(double step) { return std::fabs(step) < kSteep ? 0.0f : static_cast<float>(step); }

float anchorHeight(const TerrainCut& cut) { return 0.5f * (cut.minZ + cut.maxZ); }

/// Puts the float ray into lane k, t counted from `begin`, anchored at mip-0 cell (x, y).
void placeRay(const TerrainCut& cut, const Ray& ray, const exact::Clip& clip, int64_t x, int64_t y,
              RayBlock& b, int k) {
    const double px = ray.x + ray.dx * clip.begin, py = ray.y + ray.dy * clip.begin;
    const double z = exact::rayHeight(ray, clip.begin) - static_cast<double>(anchorHeight(cut));
    const double dz = ray.dz + 2.0 * ray.bend * clip.begin;
    const double length = clip.end - clip.begin;
    b.anchorX[k] = static_cast<int32_t>(x);
    b.anchorY[k] = static_cast<int32_t>(y);
    b.fx[k] = std::clamp(static_cast<float>(px - static_cast<double>(x)), 0.0f, kBelowOne);
    b.fy[k] = std::clamp(static_cast<float>(py - static_cast<double>(y)), 0.0f, kBelowOne);
    b.dx[k] = stepOf(ray.dx);
    b.dy[k] = stepOf(ray.dy);
    b.inverseDx[k] = inverseOf(ray.dx);
    b.inverseDy[k] = inverseOf(ray.dy);
    b.z[k] = static_cast<float>(z);
    b.dz[k] = static_cast<float>(dz);
    b.bend[k] = static_cast<float>(ray.bend);
    b.vertex[k] = ray.bend > 0.0
                      ? static_cast<float>(std::clamp(-dz / (2.0 * ray.bend), -1e30, 1e30))
                      : (dz < 0.0 ? 1e30f : -1e30f);
    b.tEnd[k] = static_cast<float>(length) * 1.000001f;
    const float span = std::max(0.5f * (cut.maxZ - cut.minZ), cut.codeReach);
    const double reach = std::max(std::fabs(z), static_cast<double>(span) + 1e-3);
    b.error0[k] = simd::kFloatError * static_cast<float>(reach) + simd::decodingError(cut);
    b.error1[k] = simd::kFloatError * static_cast<float>(std::fabs(dz) + 2.0 * ray.bend * length);
    b.shift1[k] = simd::kFloatError * static_cast<float>(std::fabs(ray.dx) + std::fabs(ray.dy));
    const float twice = 2.0f * cut.maxDelta;
    b.anywhere0[k] = b.error0[k] + twice * simd::kShift0;
    b.anywhere1[k] = b.error1[k] + twice * b.shift1[k];
    b.t[k] = 0.0f;
    b.x[k] = b.anchorX[k];
    b.y[k] = b.anchorY[k];
    b.steps[k] = 0;
    b.side[k] = b.below[k] = 0;
    b.result[k] = simd::kResultMiss;
    b.slot[k] = 0;
    b.mip[k] = 0;
    b.boundsOffset[k] = b.postsOffset[k] = 0;
    b.boundsZ[k] = b.boundsStep[k] = b.postsZ[k] = b.postsStep[k] = b.tileDelta[k] = 0.0f;
    b.entryLevel[k] = simd::kEnterAtTop;
    b.state[k] = simd::kLaneDirectory;
    b.level[k] = std::max(cut.rootLevel - 1, 0) + kTileLevels;
}

/// An idle lane: every field defined, nothing to do.
void placeIdle(const TerrainCut& cut, RayBlock& b, int k) {
    placeRay(cut, Ray{0, 0, 0, 1, 1, 0, 0, 0, 1}, {0.0, 1.0}, 0, 0, b, k);
    b.state[k] = simd::kLaneDone;
}

uint16_t stepCount(int32_t steps) { return static_cast<uint16_t>(std::min(steps, 0xFFFF)); }

/// Puts a cell, by its place in the tile, into lane k.
void loadHitCell(const TerrainCut& cut, uint32_t slot, int32_t x, int32_t y, simd::HitLanes& h,
                 int k) {
    const TileDesc& tile = cut.tiles[slot];
    const int mip = static_cast<int>(tile.mipFlags & kTileMipMask);
    const uint64_t index = tile.posts + static_cast<uint64_t>(y * kPostStride + x);
    h.mip[k] = mip;
    h.cellX[k] = (tile.x >> mip) + x;
    h.cellY[k] = (tile.y >> mip) + y;
    const auto put = [&](const auto* posts, auto decode) {
        h.h00[k] = decode(posts[index]);
        h.h10[k] = decode(posts[index + 1]);
        h.h01[k] = decode(posts[index + kPostStride]);
        h.h11[k] = decode(posts[index + kPostStride + 1]);
    };
    if (cut.format == 1) {
        put(static_cast<const float*>(cut.posts), [](float z) { return static_cast<double>(z); });
    } else {  // the product and the sum are exact in double, so this rounds once, as fma does
        const double step = static_cast<double>(tile.zStep), z0 = static_cast<double>(tile.z0);
        put(static_cast<const uint16_t*>(cut.posts), [=](uint16_t code) {
            return static_cast<double>(static_cast<float>(step * code + z0));
        });
    }
}

/// A cell in which nothing can be found.
void loadNoCell(simd::HitLanes& h, int k) {
    h.mip[k] = 0;
    h.cellX[k] = h.cellY[k] = h.h00[k] = h.h10[k] = h.h01[k] = h.h11[k] = 0.0;
}

/// Puts the cells of certain hits into lanes.
void loadHitCells(const TerrainCut& cut, const RayBlock& b, int count, simd::HitLanes& h) {
    for (int k = 0; k < count; ++k) {
        const int mip = b.mip[k];
        if (b.result[k] == simd::kResultHit)
            loadHitCell(cut, static_cast<uint32_t>(b.slot[k]), (b.x[k] >> mip) & 511,
                        (b.y[k] >> mip) & 511, h, k);
        else
            loadNoCell(h, k);
    }
}

/// The hit of lane k, which float lanes saw for certain and double precision found.
Hit hitOf(const RayBlock& b, const simd::HitLanes& h, int k) {
    const int mip = b.mip[k];
    Hit hit;
    hit.t = static_cast<float>(h.t[k]);
    hit.tile = static_cast<uint32_t>(b.slot[k]);
    hit.cell =
        static_cast<uint32_t>(((b.y[k] >> mip) & 511) * kSlotCells + ((b.x[k] >> mip) & 511));
    hit.u = h.u[k];
    hit.v = h.v[k];
    hit.steps = stepCount(b.steps[k]);
    hit.mip = static_cast<uint8_t>(mip);
    hit.flags = static_cast<uint8_t>(kHitValid | (h.fromBelow[k] != 0 ? kHitFromBelow : 0));
    return hit;
}

/// Lane k stands in a tile, at the level of 2 x 2 cells: a shadow ray's neighbours first as a
/// group.
void standInTile(const TerrainCut& cut, uint32_t slot, RayBlock& b, int k) {
    const TileDesc& tile = cut.tiles[slot];
    const float anchor = anchorHeight(cut);
    const auto posts = static_cast<uint32_t>(tile.posts) << (cut.format == 0 ? 1 : 2);
    const auto bounds = static_cast<uint32_t>(tile.bounds) << 2;
    b.state[k] = simd::kLaneTile;
    b.slot[k] = static_cast<int32_t>(slot);
    b.mip[k] = static_cast<int32_t>(tile.mipFlags & kTileMipMask);
    b.level[k] = b.mip[k] + 1;
    b.postsOffset[k] = static_cast<int32_t>(posts ^ 0x80000000u);
    b.boundsOffset[k] = static_cast<int32_t>(bounds ^ 0x80000000u);
    b.postsZ[k] = tile.z0 - anchor;
    b.postsStep[k] = tile.zStep;
    b.boundsZ[k] = tile.boundsZ0 - anchor;
    b.boundsStep[k] = tile.boundsStep;
    b.tileDelta[k] = tile.maxDelta;
}

enum class FirstCell { Occluded, GoesOn, Uncertain };

/// A ray that starts on the sheet at (u, v) of a cell and leaves the cell at t = exit.
struct FirstWay {
    double u, v, exit, side;  ///< side: +1 from above the sheet, -1 from below
};

/// Least value of side * f(t) / t on the way, f = ray height less surface: a straight line.
double leastOnBilinear(const exact::Cell& cell, const Ray& ray, const FirstWay& way) {
    const exact::CellRay r = exact::cellRay(ray, cell.mip);
    const double b = cell.h10 - cell.h00, c = cell.h01 - cell.h00, d = (cell.h11 - cell.h01) - b;
    const double f1 = ray.dz - (b * r.dx + c * r.dy + d * (way.u * r.dy + way.v * r.dx));
    const double f2 = ray.bend - d * r.dx * r.dy;
    return std::min(way.side * f1, way.side * (f1 + f2 * way.exit));
}

/// The same on two triangles: a straight line up to the diagonal; behind it f bends by
/// -turn (t - meets), and f / t has its only extremum at sqrt(turn meets / bend).
double leastOnTriangles(const exact::Cell& cell, const Ray& ray, const FirstWay& way) {
    const exact::CellRay r = exact::cellRay(ray, cell.mip);
    const double beyond = (way.u + way.v) - 1.0, rate = r.dx + r.dy;
    const bool upper = beyond > 0.0 || (beyond == 0.0 && rate > 0.0);
    const double f1 = ray.dz - exact::triangleSlope(cell, r, upper);
    const double meets = -beyond / rate;
    if (!(meets > 0.0 && meets < way.exit))
        return std::min(way.side * f1, way.side * (f1 + ray.bend * way.exit));
    const double turn = f1 - (ray.dz - exact::triangleSlope(cell, r, !upper));
    const auto at = [&](double t) {
        return way.side * (f1 + ray.bend * t - turn * (t - meets) / t);
    };
    double least = std::min({way.side * f1, way.side * (f1 + ray.bend * meets), at(way.exit)});
    const double extremum = std::sqrt(turn * meets / ray.bend);  // NaN where there is none
    if (extremum > meets && extremum < way.exit) least = std::min(least, at(extremum));
    return least;
}

/// The hit cell of a shadow ray, its root t = 0 divided out: f(t) / t = f1 + f2 t. On GoesOn, the
/// lane stands at the next cell.
FirstCell leaveHitCell(const TerrainCut& cut, const Hit& hit, const Ray& ray, RayBlock& b, int k) {
    if (cut.surface == kSurfaceConstant || (hit.flags & kHitStrip) != 0)
        return FirstCell::Uncertain;
    const TileDesc& tile = cut.tiles[hit.tile];
    const int mip = hit.mip;
    const int64_t x = (tile.x >> mip) + cellX(hit), y = (tile.y >> mip) + cellY(hit);
    const exact::Cell cell = exact::loadCell(cut, hit.tile, x, y);
    const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
    const exact::CellRay r = exact::cellRay(ray, mip);
    const double bb = cell.h10 - cell.h00, cc = cell.h01 - cell.h00;
    const double side = (hit.flags & kHitFromBelow) != 0 ? -1.0 : 1.0;
    const double tx = r.dx != 0.0 ? ((r.dx > 0.0 ? 1.0 - u : -u) / r.dx) : 1e30;
    const double ty = r.dy != 0.0 ? ((r.dy > 0.0 ? 1.0 - v : -v) / r.dy) : 1e30;
    const exact::Clip clip{0.0, exact::clipRay(cut, ray).end};
    const double border = std::max(std::min(tx, ty), 0.0),
                 exit = std::min(border, std::max(clip.end, 0.0));
    const double least = cut.surface == kSurfaceTriangles
                             ? leastOnTriangles(cell, ray, {u, v, exit, side})
                             : leastOnBilinear(cell, ray, {u, v, exit, side});
    const double unsure =
        1e-9 * (std::fabs(ray.dz) + std::fabs(bb * r.dx) + std::fabs(cc * r.dy) + 1e-6);
    if (least < -unsure) return FirstCell::Occluded;
    if (least < unsure) return FirstCell::Uncertain;
    if (clip.end <= border) {
        placeIdle(cut, b, k);  // leaves the terrain's box right here
        return FirstCell::GoesOn;
    }
    const int64_t size = int64_t{1} << mip;
    const double px = ray.x, py = ray.y;
    const int64_t ax = std::clamp(static_cast<int64_t>(px), x * size, (x + 1) * size - 1);
    const int64_t ay = std::clamp(static_cast<int64_t>(py), y * size, (y + 1) * size - 1);
    placeRay(cut, ray, clip, ax, ay, b, k);
    int64_t nx, ny;
    if (tx <= ty) {
        nx = ray.dx > 0.0 ? (x + 1) * size : x * size - 1;
        ny = std::clamp(static_cast<int64_t>(py + ray.dy * exit), y * size, (y + 1) * size - 1);
    } else {
        ny = ray.dy > 0.0 ? (y + 1) * size : y * size - 1;
        nx = std::clamp(static_cast<int64_t>(px + ray.dx * exit), x * size, (x + 1) * size - 1);
    }
    if (nx < 0 || ny < 0 || nx >= cut.cellsX || ny >= cut.cellsY) {
        b.state[k] = simd::kLaneDone;
        return FirstCell::GoesOn;
    }
    b.t[k] = static_cast<float>(exit);
    b.x[k] = static_cast<int32_t>(nx);
    b.y[k] = static_cast<int32_t>(ny);
    b.side[k] = side > 0.0 ? 1 : -1;
    const int tileShift = mip + kTileLevels;
    b.level[k] = tileShift;
    if ((nx >> tileShift) == (tile.x >> tileShift) && (ny >> tileShift) == (tile.y >> tileShift)) {
        standInTile(cut, hit.tile, b, k);
    }
    return FirstCell::GoesOn;
}

void occludedBlock(const TerrainCut& cut, std::span<const Hit> hits, std::span<const Ray> rays,
                   std::span<uint8_t> dark, TraceCounters& counters) {
    RayBlock b;
    int source[kBlockRays];
    int lanes = 0;
    for (size_t k = 0; k < hits.size(); ++k) {
        dark[k] = 0;
        if (!isHit(hits[k])) continue;
        ++counters.rays;
        switch (leaveHitCell(cut, hits[k], rays[k], b, lanes)) {
            case FirstCell::Occluded: dark[k] = 1; break;
            case FirstCell::Uncertain:
                dark[k] = exact::occluded(cut, hits[k], rays[k]) ? 1 : 0;
                ++counters.redone;
                break;
            case FirstCell::GoesOn:
                if (b.state[lanes] != simd::kLaneDone) source[lanes++] = static_cast<int>(k);
                break;
        }
    }
    const int padded = (lanes + 15) / 16 * 16;
    for (int k = lanes; k < padded; ++k) placeIdle(cut, b, k);
    simd::traceBlock(cut, b, padded);
    for (int k = 0; k < lanes; ++k) {
        const auto from = static_cast<size_t>(source[k]);
        counters.steps += static_cast<uint64_t>(b.steps[k]);
        dark[from] = b.result[k] == simd::kResultHit ? 1 : 0;
        if (b.result[k] == simd::kResultUncertain) {
            dark[from] = exact::occluded(cut, hits[from], rays[from]) ? 1 : 0;
            ++counters.redone;
        }
    }
    for (size_t k = 0; k < hits.size(); ++k) counters.hits += dark[k];
}

}  // namespace

void firstHits(const TerrainCut& cut, RayBatch& batch, int count, int level, std::span<Hit> hits,
               TraceCounters& counters) {
    RayBlock b;
    simd::HitLanes h;
    const int padded = (count + 15) / 16 * 16;
    for (int k = count; k < padded; ++k) {
        batch.set(k, batch.ray(0));
        batch.end[k] = -1e300;
    }
    simd::placeRays(cut, batch, b, padded, level);
    simd::traceBlock(cut, b, padded);
    const bool inLanes = cut.surface != kSurfaceConstant;
    if (inLanes) {
        loadHitCells(cut, b, padded, h);
        simd::finishHits(batch, h, padded, cut.surface);
    }
    for (int k = 0; k < count; ++k) {
        Hit& hit = hits[static_cast<size_t>(k)];
        counters.steps += static_cast<uint64_t>(b.steps[k]);
        batch.above[k] = b.below[k] == 0;
        if (b.result[k] == simd::kResultMiss) {
            hit = Hit{};
            hit.steps = stepCount(b.steps[k]);
        } else if (b.result[k] == simd::kResultHit && inLanes && !std::isnan(h.t[k])) {
            hit = hitOf(b, h, k);
        } else {
            Ray ray = batch.ray(k);
            ray.tMin = std::max(ray.tMin, batch.clear[k]);
            hit = exact::firstHit(cut, ray);
            batch.above[k] = isHit(hit) && cut.hasHoles == 0;
            counters.steps += hit.steps;
            ++counters.redone;
        }
        batch.above[k] = batch.above[k] && (hit.flags & kHitFromBelow) == 0;
        counters.hits += isHit(hit) ? 1u : 0u;
    }
    counters.rays += static_cast<uint64_t>(count);
}

void hitsInCells(const TerrainCut& cut, RayBatch& batch, int count, std::span<Hit> hits) {
    simd::HitLanes h;
    const int padded = (count + 15) / 16 * 16;
    for (int k = 0; k < padded; ++k) {
        if (k < count) {
            const Hit& hit = hits[static_cast<size_t>(k)];
            loadHitCell(cut, hit.tile, static_cast<int32_t>(cellX(hit)),
                        static_cast<int32_t>(cellY(hit)), h, k);
        } else {
            batch.set(k, batch.ray(0));
            loadNoCell(h, k);
        }
    }
    simd::finishHits(batch, h, padded, cut.surface);
    for (int k = 0; k < count; ++k) {
        Hit& hit = hits[static_cast<size_t>(k)];
        hit.t = static_cast<float>(h.t[k]);
        hit.u = h.u[k];
        hit.v = h.v[k];
        hit.flags = std::isnan(h.t[k]) || h.fromBelow[k] != 0 ? uint8_t{0} : uint8_t{kHitValid};
    }
}

void firstHits(const TerrainCut& cut, std::span<const Ray> rays, std::span<Hit> hits,
               TraceCounters& counters) {
    RayBatch batch;
    for (size_t first = 0; first < rays.size(); first += kBatchRays) {
        const size_t count = std::min<size_t>(kBatchRays, rays.size() - first);
        for (size_t k = 0; k < count; ++k) batch.set(static_cast<int>(k), rays[first + k]);
        firstHits(cut, batch, static_cast<int>(count), simd::kEnterAtTop,
                  hits.subspan(first, count), counters);
    }
}

void occluded(const TerrainCut& cut, std::span<const Hit> hits, std::span<const Ray> rays,
              std::span<uint8_t> occluded, TraceCounters& counters) {
    for (size_t first = 0; first < rays.size(); first += kBlockRays) {
        const size_t count = std::min<size_t>(kBlockRays, rays.size() - first);
        occludedBlock(cut, hits.subspan(first, count), rays.subspan(first, count),
                      occluded.subspan(first, count), counters);
    }
}

}  // namespace terray
