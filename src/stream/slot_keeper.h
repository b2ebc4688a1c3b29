// SPDX-License-Identifier: Apache-2.0
// Which numbered things (tiles of heights, blocks of a photo) hold the slots of a pool: what is
// wanted is loaded, what was wanted longest ago makes room for it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "stream/slot_loader.h"

namespace terray {

/// How long requests took, to 4 %.
class LatencyFigures {
public:
    void add(double ms);
    /// Milliseconds that a share of the requests did not exceed; 0 without any.
    double quantile(double share) const;

private:
    std::array<uint32_t, 512> counts_{};
    uint64_t total_ = 0;
};

/// Figures since the start.
struct StreamFigures {
    uint64_t loaded = 0, evicted = 0, failed = 0;
    uint64_t bytesRead = 0;  ///< of files
    LatencyFigures latency;  ///< from the first request to the filled slot
};

/// How long somebody tries to have what cannot be read.
struct Patience {
    int attempts = 3;    ///< of who waits for it
    int doublings = 10;  ///< of the delay of 40 ms until the next one: 41 s
};
/// Of a server, which comes back: 5 s at the most between attempts.
constexpr Patience kPatienceWithServers{5, 7};

/// What a pool has to do when slots change hands. None may be empty.
struct SlotHooks {
    std::function<void(uint32_t slot, uint32_t number)> give;     ///< before it is filled
    std::function<void(uint32_t slot)> takeAway;                  ///< nothing is in it any more
    std::function<void(std::span<const uint32_t> numbers)> show;  ///< these are in the table now
    std::function<void()> stop;  ///< at the end: nobody waits for what is being read
    std::string thing;           ///< for messages: "tile"
};

/// Changes the page table, so nobody may read that while it is called. confined.
class SlotKeeper {
public:
    /// `table`: the pool's slot of each number, kNoSlot for what is not there. Borrowed.
    SlotKeeper(std::vector<uint32_t>& table, uint32_t slots, SlotHooks hooks, MakeFiller makeFiller,
               int threads, Patience patience = {});
    /// Stops the source, and waits for what is being filled.
    ~SlotKeeper();
    SlotKeeper(const SlotKeeper&) = delete;
    SlotKeeper& operator=(const SlotKeeper&) = delete;

    /// Slots for what comes and goes.
    size_t room() const { return room_; }
    /// These, which are there, stay.
    void keep(std::span<const uint32_t> numbers);

    /// Shows what has arrived and asks for what is absent: the wanted ones first, in their order,
    /// then those that will be wanted soon, as far as nothing wanted has to make room. Returns at
    /// once; the number of wanted ones that are absent.
    size_t update(std::span<const uint32_t> wanted, std::span<const uint32_t> soon = {});

    /// The same until all wanted ones are there. They must fit. What cannot be read is tried again
    /// a few times; then the error of such a one (the others are there). Interrupted.
    Result<void> bring(std::span<const uint32_t> wanted);

    const StreamFigures& figures() const { return figures_; }

private:
    enum class State : uint8_t { Absent, Asked, Here };
    struct Failure {
        Error error;
        int attempts = 0;
        SteadyTime retryAt;
    };
    void takeBackJobs();
    void show(const std::vector<FilledSlot>& filled);
    void fail(const SlotJob& job, const Error& error);
    void tell(const Error& error);
    void release(uint32_t slot);
    bool mayAsk(uint32_t number) const;
    bool isWorthWaiting(uint32_t number) const;
    size_t askFor(std::span<const uint32_t> numbers, uint64_t rank);
    uint32_t freeSlot(uint64_t rank);

    std::vector<uint32_t>& table_;
    SlotHooks hooks_;
    std::vector<State> states_;      ///< per number
    std::vector<uint32_t> holders_;  ///< per slot: who is in it or on the way; kNoSlot: nobody
    std::vector<uint64_t> usedAt_;   ///< per slot: rank of the last update that named it
    std::vector<uint8_t> isKept_;    ///< per slot
    std::vector<uint32_t> free_;     ///< slots
    std::unordered_map<uint32_t, Failure> failures_;       ///< by number
    std::unordered_map<uint32_t, SteadyTime> askedSince_;  ///< of jobs that were taken back
    Patience patience_;
    int named_ = 0;  ///< whose failure was told
    size_t room_ = 0;
    uint64_t now_ = 0;  ///< rank of what is wanted; what is wanted soon has the one before
    StreamFigures figures_;
    SlotLoader loader_;  ///< last: its threads end before what they write to
};

}  // namespace terray
