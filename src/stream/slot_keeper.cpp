// SPDX-License-Identifier: Apache-2.0
// Slots go from free to asked to shown, and back when they were not wanted for longest.
#include "stream/slot_keeper.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "base/assert.h"
#include "base/interrupt.h"
#include "base/log.h"
#include "base/progress.h"
#include "kernel/layout/layout.h"

namespace terray {
namespace {

constexpr std::chrono::milliseconds kLook{100};       ///< between looks for Ctrl-C
constexpr std::chrono::milliseconds kFirstDelay{40};  ///< until something is tried again
constexpr int kMostNamed = 20;                        ///< failures that are told one by one

constexpr double kLeastMs = 0.001, kBinWidth = 0.04;  ///< of the logarithm

}  // namespace

void LatencyFigures::add(double ms) {
    const double bin = std::log(std::max(ms, kLeastMs) / kLeastMs) / kBinWidth;
    ++counts_[std::min(static_cast<size_t>(bin), counts_.size() - 1)];
    ++total_;
}

double LatencyFigures::quantile(double share) const {
    if (total_ == 0) return 0;
    const auto wanted = static_cast<uint64_t>(std::ceil(share * static_cast<double>(total_)));
    uint64_t sum = 0;
    size_t bin = 0;
    while (bin + 1 < counts_.size() && (sum += counts_[bin]) < wanted) ++bin;
    return kLeastMs * std::exp((static_cast<double>(bin) + 0.5) * kBinWidth);
}

SlotKeeper::SlotKeeper(std::vector<uint32_t>& table, uint32_t slots, SlotHooks hooks,
                       MakeFiller makeFiller, int threads, Patience patience)
    : table_(table),
      hooks_(std::move(hooks)),
      states_(table.size(), State::Absent),
      holders_(slots, kNoSlot),
      usedAt_(slots, 0),
      isKept_(slots, 0),
      patience_(patience),
      room_(slots),
      loader_(std::move(makeFiller), threads) {
    for (uint32_t slot = slots; slot > 0; --slot) free_.push_back(slot - 1);
}

SlotKeeper::~SlotKeeper() { hooks_.stop(); }

void SlotKeeper::keep(std::span<const uint32_t> numbers) {
    for (const uint32_t number : numbers) {
        TERRAY_ASSERT(table_[number] != kNoSlot && isKept_[table_[number]] == 0);
        isKept_[table_[number]] = 1;
    }
    room_ -= numbers.size();
}

size_t SlotKeeper::update(std::span<const uint32_t> wanted, std::span<const uint32_t> soon) {
    now_ += 2;
    show(loader_.take(std::chrono::milliseconds(0)));
    takeBackJobs();
    const auto name = [&](std::span<const uint32_t> numbers, uint64_t rank) {
        for (const uint32_t number : numbers) {
            const uint32_t slot = table_[number];
            if (slot != kNoSlot) usedAt_[slot] = std::max(usedAt_[slot], rank);
        }
    };
    name(wanted, now_);
    name(soon, now_ - 1);
    const size_t absent = askFor(wanted, now_);
    askFor(soon, now_ - 1);
    askedSince_.clear();
    return absent;
}

/// The number of those that are absent.
size_t SlotKeeper::askFor(std::span<const uint32_t> numbers, uint64_t rank) {
    size_t absent = 0;
    bool isFull = false;
    for (const uint32_t number : numbers) {
        if (table_[number] != kNoSlot) continue;
        ++absent;
        if (isFull || !mayAsk(number)) continue;
        const uint32_t slot = freeSlot(rank);
        isFull = slot == kNoSlot;
        if (isFull) continue;
        usedAt_[slot] = rank;
        holders_[slot] = number;
        states_[number] = State::Asked;
        hooks_.give(slot, number);
        const auto before = askedSince_.find(number);
        loader_.ask(
            {number, slot,
             before != askedSince_.end() ? before->second : std::chrono::steady_clock::now()});
    }
    return absent;
}

void SlotKeeper::takeBackJobs() {
    for (const SlotJob& job : loader_.takeBack()) {
        states_[job.number] = State::Absent;
        askedSince_[job.number] = job.since;
        release(job.slot);
    }
}

void SlotKeeper::release(uint32_t slot) {
    holders_[slot] = kNoSlot;
    hooks_.takeAway(slot);
    free_.push_back(slot);
}

bool SlotKeeper::mayAsk(uint32_t number) const {
    if (states_[number] != State::Absent) return false;
    const auto failure = failures_.find(number);
    return failure == failures_.end() ||
           failure->second.retryAt <= std::chrono::steady_clock::now();
}

bool SlotKeeper::isWorthWaiting(uint32_t number) const {
    if (table_[number] != kNoSlot) return false;
    const auto failure = failures_.find(number);
    return failure == failures_.end() || failure->second.attempts < patience_.attempts;
}

Result<void> SlotKeeper::bring(std::span<const uint32_t> wanted) {
    size_t left = update(wanted);
    Progress progress(fmt::format("Loading {}s", hooks_.thing), static_cast<double>(left));
    const auto isWaiting = [&] {
        return std::any_of(wanted.begin(), wanted.end(),
                           [&](uint32_t number) { return isWorthWaiting(number); });
    };
    while (isWaiting()) {
        if (isInterrupted()) return makeError(ErrorCode::Interrupted, "interrupted");
        show(loader_.take(kLook));
        if (!failures_.empty()) std::this_thread::sleep_for(kFirstDelay / 4);
        const size_t before = left;
        left = update(wanted);
        progress.advance(static_cast<double>(before) - static_cast<double>(left));
    }
    for (const uint32_t number : wanted) {
        const auto failure = failures_.find(number);
        if (failure != failures_.end()) return failure->second.error;
    }
    return {};
}

void SlotKeeper::show(const std::vector<FilledSlot>& filled) {
    std::vector<uint32_t> shown;
    for (const FilledSlot& slot : filled) {
        figures_.bytesRead += slot.bytesRead;
        if (!slot.outcome) {
            fail(slot.job, slot.outcome.error());
            continue;
        }
        const uint32_t number = slot.job.number;
        states_[number] = State::Here;
        table_[number] = slot.job.slot;
        failures_.erase(number);
        ++figures_.loaded;
        figures_.latency.add(slot.latencyMs);
        shown.push_back(number);
    }
    if (!shown.empty()) hooks_.show(shown);
}

void SlotKeeper::tell(const Error& error) {
    if (error.code == ErrorCode::Interrupted) return;
    ++named_;
    if (named_ > kMostNamed) return;
    log::warning("{} (a coarser {} stands in{})", error.message, hooks_.thing,
                 named_ < kMostNamed ? "" : "; more of them are not told");
}

/// Tried again later and later; named once.
void SlotKeeper::fail(const SlotJob& job, const Error& error) {
    states_[job.number] = State::Absent;
    release(job.slot);
    ++figures_.failed;
    Failure& failure = failures_.try_emplace(job.number, Failure{error, 0, {}}).first->second;
    if (failure.attempts == 0) tell(error);
    const auto delay = kFirstDelay * (1 << std::min(2 * failure.attempts, patience_.doublings));
    failure.retryAt = std::chrono::steady_clock::now() + delay;
    failure.error = error;
    ++failure.attempts;
}

/// A slot that nothing is in, or the one that was not named for longest, and not since `rank`;
/// kNoSlot if there is none.
uint32_t SlotKeeper::freeSlot(uint64_t rank) {
    if (free_.empty()) {
        uint32_t oldest = kNoSlot;
        for (uint32_t slot = 0; slot < usedAt_.size(); ++slot) {
            const bool isShown = holders_[slot] != kNoSlot && table_[holders_[slot]] == slot;
            if (isKept_[slot] || usedAt_[slot] >= rank || !isShown) continue;
            if (oldest == kNoSlot || usedAt_[slot] < usedAt_[oldest]) oldest = slot;
        }
        if (oldest == kNoSlot) return kNoSlot;
        table_[holders_[oldest]] = kNoSlot;
        states_[holders_[oldest]] = State::Absent;
        holders_[oldest] = kNoSlot;
        ++figures_.evicted;
        return oldest;
    }
    const uint32_t slot = free_.back();
    free_.pop_back();
    return slot;
}

}  // namespace terray
