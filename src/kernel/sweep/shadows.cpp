// SPDX-License-Identifier: Apache-2.0
// Shadow rays by a sun sweep: those that it serves go into lanes, the rest to `occluded`.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/assert.h"
#include "kernel/height.h"
#include "kernel/ray_batch.h"
#include "kernel/simd/shadow_lanes.h"
#include "kernel/sweep/sun.h"

namespace terray {
namespace {

/// Rays for `occluded`, collected until there are enough for its packets.
class CastList {
public:
    CastList(const TerrainCut& cut, const SunDirection& sun, std::span<uint8_t> dark,
             ShadowCounters& counters)
        : cut_(cut), sun_(sun), dark_(dark), counters_(counters) {}

    void add(const Hit& hit, float z, size_t target) {
        hits_[count_] = hit;
        rays_[count_] = sunRay(cut_, sun_, hit, z);
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
    const SunDirection& sun_;
    std::span<uint8_t> dark_;
    ShadowCounters& counters_;
    std::array<Hit, kBatchRays> hits_;
    std::array<Ray, kBatchRays> rays_;
    std::array<size_t, kBatchRays> targets_;
    size_t count_ = 0;
};

/// Rays on their way: blocks of the tiles that were asked for last, and rays that have left theirs.
class Walker {
public:
    Walker(const TerrainCut& cut, const SunSweep& sweep, uint8_t* verdicts,
           ShadowCounters& counters)
        : cut_(cut), sweep_(sweep), verdicts_(verdicts), counters_(counters) {}

    /// Starts the rays of a batch, the first of which is number `first`.
    void start(const SunAsks& asks, int first) {
        uint32_t slot = kNoSlot, unlike = 0;
        for (const uint32_t tile : asks.tile) slot = std::min(slot, tile);
        if (slot == kNoSlot) return;
        for (const uint32_t tile : asks.tile) unlike |= tile == kNoSlot ? 0 : tile ^ slot;
        startIn(slot, asks, first);
        while (unlike != 0) {
            uint32_t next = kNoSlot;
            for (const uint32_t tile : asks.tile) next = tile > slot ? std::min(next, tile) : next;
            if (next == kNoSlot) break;
            slot = next;
            startIn(slot, asks, first);
        }
    }
    void finish() {
        for (bool any = true; any;) {
            any = roaming_.count > 0;
            finishRoaming();
            for (Open& open : open_) {
                any = any || open.block.count + open.hits.count > 0;
                if (open.hits.count > 0) leave(open, true);
                if (open.block.count > 0) walk(open.slot, open.block, 0);
            }
        }
    }

private:
    static constexpr int kRoamers = 4 * simd::kShadowRays;
    static constexpr int kRest = 64;  ///< rays that wait in a block for others
    static constexpr int kMostHits = 128;

    struct Open {
        uint32_t slot = kNoSlot;
        simd::ShadowBlock hits;  ///< rays that have not left the cell of their hit
        simd::ShadowBlock block;
    };
    /// Rays that stand at the border of the tile that they go on in, which is not open.
    struct Roaming {
        std::array<simd::ShadowRay, kRoamers> rays;
        std::array<uint32_t, kRoamers> slots;
        int count = 0;
    };

    void startIn(uint32_t slot, const SunAsks& asks, int first) {
        Open* open = openBlock(slot);
        if (open == nullptr) {
            open = &open_[next_++ % open_.size()];
            if (open->hits.count > 0) leave(*open, true);
            if (open->block.count > 0) walk(open->slot, open->block, 0);
            open->slot = slot;
        }
        if (open->hits.count > kMostHits - kSunAsks) leave(*open, false);
        counters_.rays += static_cast<uint64_t>(
            simd::startShadows(cut_, sweep_, slot, asks, first, open->hits, verdicts_));
    }
    void leave(Open& open, bool all) {
        if (open.block.count > simd::kShadowRays - kMostHits) walk(open.slot, open.block, kRest);
        if (roaming_.count > kRoamers - simd::kShadowRays - kSunAsks) finishRoaming();
        counters_.cells += simd::leaveHits(cut_, sweep_, open.slot, all, open.hits, open.block,
                                           leaving_, verdicts_);
        passOn(open.slot);
    }
    Open* openBlock(uint32_t slot) {
        for (Open& open : open_)
            if (open.slot == slot) return &open;
        return nullptr;
    }
    void walk(uint32_t slot, simd::ShadowBlock& block, int rest) {
        // Room for all of the block, and for what starts next.
        if (roaming_.count > kRoamers - simd::kShadowRays - kSunAsks) finishRoaming();
        counters_.cells += simd::walkShadows(cut_, sweep_, slot, rest, block, leaving_, verdicts_);
        passOn(slot);
    }
    /// Takes over what has left a tile.
    void passOn(uint32_t slot);
    /// Walks on tile by tile; there are never more rays than before.
    void finishRoaming();

    const TerrainCut& cut_;
    const SunSweep& sweep_;
    uint8_t* verdicts_;
    ShadowCounters& counters_;
    std::array<Open, 4> open_;
    size_t next_ = 0;
    simd::ShadowLeaving leaving_;
    simd::ShadowBlock through_;
    Roaming roaming_;
};

void Walker::passOn(uint32_t slot) {
    const SweptTile& tile = sweep_.tile(slot);
    for (simd::ShadowBlock* block : {&leaving_.ahead, &leaving_.aside}) {
        const bool ahead = block == &leaving_.ahead;
        const uint32_t next = ahead ? tile.ahead : tile.aside;
        Open* open = block->count > 0 ? openBlock(next) : nullptr;
        for (int k = 0; k < block->count; ++k) {
            simd::ShadowRay ray = block->ray(k);
            if (next == kUnlikeTile) verdicts_[ray.source] = simd::kShadowUndecided;
            if (next == kUnlikeTile || next == kBeyondTerrain) continue;
            (ahead ? ray.row : ray.column) = 0;
            if (open != nullptr && open->block.count < simd::kShadowRays) {
                open->block.add(ray);
                continue;
            }
            const auto to = static_cast<size_t>(roaming_.count++);
            roaming_.rays[to] = ray;
            roaming_.slots[to] = next;
        }
        block->count = 0;
    }
}

void Walker::finishRoaming() {
    while (roaming_.count > 0) {
        const uint32_t slot = roaming_.slots[static_cast<size_t>(roaming_.count - 1)];
        int kept = 0;
        for (int k = 0; k < roaming_.count; ++k) {
            const auto from = static_cast<size_t>(k), to = static_cast<size_t>(kept);
            if (roaming_.slots[from] == slot && through_.count < simd::kShadowRays) {
                through_.add(roaming_.rays[from]);
                continue;
            }
            roaming_.rays[to] = roaming_.rays[from];
            roaming_.slots[to] = roaming_.slots[from];
            ++kept;
        }
        roaming_.count = kept;
        counters_.cells += simd::walkShadows(cut_, sweep_, slot, 0, through_, leaving_, verdicts_);
        passOn(slot);
    }
}

}  // namespace

Ray sunRay(const TerrainCut& cut, const SunDirection& sun, const Hit& hit, float z) {
    const LatticePlace place = hitPlace(cut, hit);
    return sun.rayFrom(place.i, place.j, static_cast<double>(z));
}

void shadows(const TerrainCut& cut, const SunSweep& sweep, std::span<const Hit> hits,
             std::span<const SunAsks> asks, std::span<uint8_t> dark, ShadowCounters& counters) {
    TERRAY_ASSERT(dark.size() == asks.size() * kSunAsks);
    TERRAY_ASSERT(hits.size() <= dark.size());
    std::fill(dark.begin(), dark.end(), uint8_t{simd::kShadowLit});
    Walker walker(cut, sweep, dark.data(), counters);
    CastList rest(cut, sweep.sun(), dark, counters);
    const auto cast = [&](size_t k) { rest.add(hits[k], asks[k / kSunAsks].z[k % kSunAsks], k); };
    for (size_t n = 0; n < asks.size(); ++n) {
        walker.start(asks[n], static_cast<int>(n) * kSunAsks);
        for (uint64_t bits = asks[n].strange; bits != 0; bits &= bits - 1) {
            ++counters.rays;
            cast(n * kSunAsks + static_cast<size_t>(std::countr_zero(bits)));
        }
    }
    walker.finish();
    for (size_t n = 0; n < asks.size(); ++n) {
        const uint8_t* verdicts = dark.data() + n * kSunAsks;
        uint8_t any = 0;
        for (size_t k = 0; k < kSunAsks; ++k) any |= verdicts[k];
        for (size_t k = 0; (any & simd::kShadowUndecided) != 0 && k < kSunAsks; ++k)
            if (verdicts[k] == simd::kShadowUndecided) cast(n * kSunAsks + k);
    }
    rest.cast();
    for (const uint8_t d : dark) counters.dark += d;
}

}  // namespace terray
