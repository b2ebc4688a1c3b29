// SPDX-License-Identifier: Apache-2.0
// Shadow rays by a sun sweep: those that it serves go into lanes, the rest to `occluded`.
#include <algorithm>
#include <array>
#include <cmath>

#include "kernel/simd/shadow_lanes.h"
#include "kernel/sweep/sun.h"

namespace terray {
namespace {

/// Rays for `occluded`, collected until there are enough for its packets.
class CastList {
public:
    CastList(const TerrainCut& cut, std::span<uint8_t> dark, ShadowCounters& counters)
        : cut_(cut), dark_(dark), counters_(counters) {}

    void add(const Hit& hit, const Ray& ray, size_t target) {
        hits_[count_] = hit;
        rays_[count_] = ray;
        targets_[count_] = target;
        if (++count_ == kBatchRays) cast();
    }
    void cast() {
        if (count_ == 0) return;
        std::array<uint8_t, kBatchRays> dark;
        occluded(cut_, std::span(hits_).first(count_), std::span(rays_).first(count_),
                 std::span(dark).first(count_), counters_.traced);
        for (size_t k = 0; k < count_; ++k) dark_[targets_[k]] = dark[k];
        counters_.cast += count_;
        count_ = 0;
    }

private:
    const TerrainCut& cut_;
    std::span<uint8_t> dark_;
    ShadowCounters& counters_;
    std::array<Hit, kBatchRays> hits_;
    std::array<Ray, kBatchRays> rays_;
    std::array<size_t, kBatchRays> targets_;
    size_t count_ = 0;
};

/// True if the ray leaves a place on the upper side of a swept tile's cell towards the sweep's sun.
bool isServed(const TerrainCut& cut, const SunSweep& sweep, const Hit& hit, const Ray& ray) {
    const SunDirection& sun = sweep.sun();
    if (hit.flags != kHitValid || sweep.tile(hit.tile).posts == nullptr) return false;
    if (ray.dx != sun.dx || ray.dy != sun.dy || ray.bend != sun.bend) return false;
    if (ray.tMin != 0 || ray.tMax < 1e30) return false;
    if (std::fabs(ray.dz - sun.slopeAt(ray.x, ray.y)) > sweep.slopeTolerance()) return false;
    // Far above the ground a float of its height would be worse than the sweep's.
    return ray.z <= static_cast<double>(cut.maxZ) + 1.0;
}

/// Rays that are walked together: up to kGroup at a time, tile by tile.
class Walker {
public:
    Walker(const TerrainCut& cut, const SunSweep& sweep, ShadowCounters& counters)
        : cut_(cut), sweep_(sweep), counters_(counters) {}

    static constexpr size_t kGroup = 1024;

    void start() {
        results_.fill(simd::kShadowLit);
        tileCount_ = 0;
        count_ = 0;
    }
    void add(const Hit& hit, const Ray& ray, size_t source) {
        if (count_ == 0 || hit.tile != tiles_[lastTile_].slot) lastTile_ = tileOf(hit.tile);
        Queued& queued = rays_[count_];
        queued = {&hit, &ray, static_cast<int32_t>(source), tiles_[lastTile_].first};
        tiles_[lastTile_].first = static_cast<int32_t>(count_++);
    }
    /// Walks all rays; results by source.
    const int32_t* walk() {
        for (size_t n = 0; n < tileCount_; ++n) walkTile(tiles_[n]);
        return results_.data();
    }

private:
    struct Queued {
        const Hit* hit;
        const Ray* ray;
        int32_t source, next;
    };
    struct TileList {
        uint32_t slot;
        int32_t first;
    };

    size_t tileOf(uint32_t slot) {
        for (size_t n = 0; n < tileCount_; ++n)
            if (tiles_[n].slot == slot) return n;
        tiles_[tileCount_] = {slot, -1};
        return tileCount_++;
    }
    void walkTile(const TileList& list) {
        const SweptTile& tile = sweep_.tile(list.slot);
        int count = 0;
        for (int32_t k = list.first; k >= 0; k = rays_[static_cast<size_t>(k)].next) {
            fillLane(tile, rays_[static_cast<size_t>(k)], static_cast<size_t>(count++));
            if (count < simd::kShadowRays) continue;
            walkBlock(list.slot, count, true);
            count = 0;
        }
        if (count > 0) walkBlock(list.slot, count, true);
    }
    void fillLane(const SweptTile& tile, const Queued& queued, size_t k) {
        const Hit& hit = *queued.hit;
        block_.column[k] = static_cast<int32_t>(cellX(hit));
        block_.row[k] = static_cast<int32_t>(cellY(hit));
        block_.u[k] = hit.u;
        block_.v[k] = hit.v;
        block_.z[k] = static_cast<float>(queued.ray->z - static_cast<double>(sweep_.anchorZ()));
        block_.dz[k] = static_cast<float>(queued.ray->dz) * tile.perRow;
        block_.crossed[k] = 0.0f;
        block_.source[k] = queued.source;
    }
    /// Walks the block through its tile, and then on through the tiles behind.
    void walkBlock(uint32_t slot, int count, bool atHits);

    const TerrainCut& cut_;
    const SunSweep& sweep_;
    ShadowCounters& counters_;
    simd::ShadowBlock block_;
    std::array<Queued, kGroup> rays_;
    std::array<TileList, kGroup> tiles_;
    size_t tileCount_ = 0, count_ = 0, lastTile_ = 0;
    std::array<int32_t, kGroup> results_;
};

void Walker::walkBlock(uint32_t slot, int count, bool atHits) {
    simd::ShadowBlock leaving;
    int leavingCount = 0;
    const SweptTile& tile = sweep_.tile(slot);
    counters_.cells += simd::walkShadows(cut_, sweep_, tile, block_, count, atHits, results_.data(),
                                         leaving, leavingCount);
    for (const int32_t way : {simd::kShadowAhead, simd::kShadowAside}) {
        const uint32_t next = way == simd::kShadowAhead ? tile.ahead : tile.aside;
        int moved = 0;
        for (int k = 0; k < leavingCount; ++k) {
            const auto from = static_cast<size_t>(k);
            if (leaving.result[k] != way) continue;
            if (next == kBeyondTerrain || next == kUnlikeTile) {
                results_[static_cast<size_t>(leaving.source[k])] =
                    next == kBeyondTerrain ? simd::kShadowLit : simd::kShadowUndecided;
                continue;
            }
            block_.copyRay(static_cast<size_t>(moved), leaving, from);
            (way == simd::kShadowAhead ? block_.row : block_.column)[moved++] = 0;
        }
        if (moved > 0) walkBlock(next, moved, false);
    }
}

}  // namespace

void shadows(const TerrainCut& cut, const SunSweep& sweep, std::span<const Hit> hits,
             std::span<const Ray> rays, std::span<uint8_t> dark, ShadowCounters& counters) {
    Walker walker(cut, sweep, counters);
    CastList rest(cut, dark, counters);
    for (size_t first = 0; first < hits.size(); first += Walker::kGroup) {
        const size_t end = std::min(hits.size(), first + Walker::kGroup);
        walker.start();
        for (size_t k = first; k < end; ++k) {
            dark[k] = 0;
            if (!isHit(hits[k])) continue;
            ++counters.rays;
            if (isServed(cut, sweep, hits[k], rays[k]))
                walker.add(hits[k], rays[k], k - first);
            else
                rest.add(hits[k], rays[k], k);
        }
        const int32_t* results = walker.walk();
        for (size_t k = first; k < end; ++k) {
            if (results[k - first] == simd::kShadowDark) dark[k] = 1;
            if (results[k - first] == simd::kShadowUndecided) rest.add(hits[k], rays[k], k);
        }
    }
    rest.cast();
    for (const uint8_t d : dark) counters.dark += d;
}

}  // namespace terray
