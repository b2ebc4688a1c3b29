// SPDX-License-Identifier: Apache-2.0
// Residency: slots go from free to asked to shown, and back when they were not wanted for longest.
#include "stream/streamer.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "base/assert.h"
#include "base/interrupt.h"
#include "base/log.h"
#include "base/progress.h"
#include "stream/slot.h"

namespace terray {
namespace {

constexpr std::chrono::milliseconds kPatience{100};   ///< between looks for Ctrl-C
constexpr std::chrono::milliseconds kFirstDelay{40};  ///< until a tile is tried again
constexpr int kMostDoublings = 10;                    ///< of that delay: 41 s
constexpr int kRemoteDoublings = 7;                   ///< 5 s: a server comes back
constexpr int kAttempts = 3, kRemoteAttempts = 5;     ///< of who waits for a tile
constexpr int kMostNamed = 20;                        ///< failures that are told one by one
constexpr TileId kNoTile{-1, 0, 0};

}  // namespace

Streamer::Streamer(const TileSource& source, ResidentTerrain::Pool& pool, int threads)
    : pool_(pool),
      states_(pool.slots.size(), State::Absent),
      usedAt_(pool.tiles.size(), 0),
      isKept_(pool.tiles.size(), 0),
      attempts_(source.isRemote() ? kRemoteAttempts : kAttempts),
      mostDoublings_(source.isRemote() ? kRemoteDoublings : kMostDoublings),
      loader_(source, pool, threads) {
    for (auto slot = static_cast<uint32_t>(pool.tiles.size()); slot > 0; --slot) {
        free_.push_back(slot - 1);
    }
    room_ = free_.size();
}

Result<std::unique_ptr<Streamer>> Streamer::make(const TileSource& source,
                                                 ResidentTerrain::Pool& pool, int threads) {
    std::unique_ptr<Streamer> streamer(new Streamer(source, pool, threads));
    std::vector<TileId> kept;
    for (uint32_t number = pool.firstTile[static_cast<size_t>(pool.firstKept)];
         number < pool.slots.size(); ++number) {
        if (!pool.isHollow(number)) kept.push_back(pool.tileOf(number));
    }
    std::reverse(kept.begin(), kept.end());  // coarse ones first
    TERRAY_ASSERT(kept.size() <= streamer->room_);
    TERRAY_TRY(streamer->bring(kept));
    for (const TileId id : kept) streamer->isKept_[pool.slotOf(id)] = 1;
    streamer->room_ -= kept.size();
    return streamer;
}

bool Streamer::fits(std::span<const TileId> tiles) const {
    const auto comes = [&](TileId id) { return id.mip < pool_.firstKept; };
    return static_cast<size_t>(std::count_if(tiles.begin(), tiles.end(), comes)) <= room_;
}

size_t Streamer::update(std::span<const TileId> wanted) {
    ++now_;
    show(loader_.take(std::chrono::milliseconds(0)));
    takeBackJobs();
    for (const TileId id : wanted) {
        const uint32_t slot = pool_.slotOf(id);
        if (slot != kNoSlot) usedAt_[slot] = now_;
    }
    size_t absent = 0;
    bool isFull = false;
    for (const TileId id : wanted) {
        const uint32_t number = pool_.numberOf(id);
        if (pool_.isHere(number)) continue;
        ++absent;
        if (isFull || !mayAsk(number)) continue;
        const uint32_t slot = freeSlot();
        isFull = slot == kNoSlot;
        if (isFull) continue;
        usedAt_[slot] = now_;
        states_[number] = State::Asked;
        pool_.assign(slot, id);
        loader_.ask({id, slot});
    }
    return absent;
}

void Streamer::takeBackJobs() {
    for (const TileJob& job : loader_.takeBack()) {
        states_[pool_.numberOf(job.id)] = State::Absent;
        pool_.ids[job.slot] = kNoTile;
        free_.push_back(job.slot);
    }
}

bool Streamer::mayAsk(uint32_t number) const {
    if (states_[number] != State::Absent) return false;
    const auto failure = failures_.find(number);
    return failure == failures_.end() ||
           failure->second.retryAt <= std::chrono::steady_clock::now();
}

bool Streamer::isWorthWaiting(uint32_t number) const {
    if (pool_.isHere(number)) return false;
    const auto failure = failures_.find(number);
    return failure == failures_.end() || failure->second.attempts < attempts_;
}

Result<void> Streamer::bring(std::span<const TileId> wanted) {
    size_t left = update(wanted);
    Progress progress("Loading tiles", static_cast<double>(left));
    const auto isWaiting = [&] {
        return std::any_of(wanted.begin(), wanted.end(),
                           [&](TileId id) { return isWorthWaiting(pool_.numberOf(id)); });
    };
    while (isWaiting()) {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        show(loader_.take(kPatience));
        if (!failures_.empty()) std::this_thread::sleep_for(kFirstDelay / 4);
        const size_t before = left;
        left = update(wanted);
        progress.advance(static_cast<double>(before) - static_cast<double>(left));
    }
    for (const TileId id : wanted) {
        const auto failure = failures_.find(pool_.numberOf(id));
        if (failure != failures_.end()) return failure->second.error;
    }
    return {};
}

void Streamer::show(const std::vector<LoadedTile>& tiles) {
    std::vector<TileId> shown;
    for (const LoadedTile& tile : tiles) {
        if (!tile.outcome) {
            fail(tile.job, tile.outcome.error());
            continue;
        }
        const uint32_t number = pool_.numberOf(tile.job.id);
        states_[number] = State::Here;
        pool_.slots[number] = tile.job.slot;
        failures_.erase(number);
        ++figures_.loaded;
        shown.push_back(tile.job.id);
    }
    if (!shown.empty()) makeRims(shown);
}

/// Sharpness at the rims of the new tiles and of their neighbours follows from both.
void Streamer::makeRims(const std::vector<TileId>& shown) {
    constexpr int kSteps[][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    std::vector<uint32_t> slots;
    for (const TileId id : shown) {
        for (const auto& step : kSteps) {
            const uint32_t slot = pool_.slotOf({id.mip, id.x + step[0], id.y + step[1]});
            if (slot != kNoSlot) slots.push_back(slot);
        }
    }
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    oneapi::tbb::parallel_for(size_t{0}, slots.size(),
                              [&](size_t k) { makeSharpness(pool_, slots[k]); });
}

void Streamer::tell(const Error& error) {
    if (error.code == ErrorCode::Interrupted) return;
    ++named_;
    if (named_ < kMostNamed) log::warning("{} (a coarser tile stands in)", error.message);
    if (named_ == kMostNamed) {
        log::warning("{} (a coarser tile stands in; more such tiles are not told)", error.message);
    }
}

/// Tried again later and later; named once.
void Streamer::fail(const TileJob& job, const Error& error) {
    const uint32_t number = pool_.numberOf(job.id);
    states_[number] = State::Absent;
    pool_.ids[job.slot] = kNoTile;
    free_.push_back(job.slot);
    ++figures_.failed;
    Failure& failure = failures_.try_emplace(number, Failure{error, 0, {}}).first->second;
    if (failure.attempts == 0) tell(error);
    const auto delay = kFirstDelay * (1 << std::min(2 * failure.attempts, mostDoublings_));
    failure.retryAt = std::chrono::steady_clock::now() + delay;
    failure.error = error;
    ++failure.attempts;
}

/// A slot that nothing is in, or the one that was not wanted for longest; kNoSlot if all are
/// wanted.
uint32_t Streamer::freeSlot() {
    if (free_.empty()) {
        uint32_t oldest = kNoSlot;
        for (uint32_t slot = 0; slot < usedAt_.size(); ++slot) {
            const bool isShown = pool_.slotOf(pool_.ids[slot]) == slot;
            if (isKept_[slot] || usedAt_[slot] == now_ || !isShown) continue;
            if (oldest == kNoSlot || usedAt_[slot] < usedAt_[oldest]) oldest = slot;
        }
        if (oldest == kNoSlot) return kNoSlot;
        const uint32_t number = pool_.numberOf(pool_.ids[oldest]);
        pool_.slots[number] = kNoSlot;
        states_[number] = State::Absent;
        ++figures_.evicted;
        return oldest;
    }
    const uint32_t slot = free_.back();
    free_.pop_back();
    return slot;
}

}  // namespace terray
