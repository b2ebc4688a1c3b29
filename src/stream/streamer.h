// SPDX-License-Identifier: Apache-2.0
// Which tiles of a source are resident: what frames want is loaded, what they wanted longest ago
// makes room for it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "stream/loader.h"

namespace terray {

/// Figures since the start.
struct StreamFigures {
    uint64_t loaded = 0, evicted = 0, failed = 0;
};

/// Changes the pool's page table, so no frame may be drawn while it is called. confined.
class Streamer {
public:
    /// Loads the mips that stay; they must fit.
    static Result<std::unique_ptr<Streamer>> make(const TileSource& source,
                                                  ResidentTerrain::Pool& pool, int threads);

    /// Slots for tiles of finer mips than those that stay.
    size_t room() const { return room_; }
    /// True if there is a slot for each of the tiles.
    bool fits(std::span<const TileId> tiles) const;

    /// Shows the tiles that have arrived and asks for the wanted ones that are absent, the first
    /// ones first. Returns at once; the number of wanted tiles that are absent.
    size_t update(std::span<const TileId> wanted);

    /// The same until all wanted tiles are there. They must fit. What cannot
    /// be read is tried again a few times; then the error of such a tile (the others are there).
    /// Interrupted.
    Result<void> bring(std::span<const TileId> wanted);

    const StreamFigures& figures() const { return figures_; }
    /// Changes whenever what is resident does.
    uint64_t version() const { return figures_.loaded + figures_.evicted; }

private:
    enum class State : uint8_t { Absent, Asked, Here };
    struct Failure {
        Error error;
        int attempts = 0;
        std::chrono::steady_clock::time_point retryAt;
    };
    Streamer(const TileSource& source, ResidentTerrain::Pool& pool, int threads);
    void takeBackJobs();
    void show(const std::vector<LoadedTile>& tiles);
    void makeRims(const std::vector<TileId>& shown);
    void fail(const TileJob& job, const Error& error);
    void tell(const Error& error);
    bool mayAsk(uint32_t number) const;
    bool isWorthWaiting(uint32_t number) const;
    uint32_t freeSlot();

    ResidentTerrain::Pool& pool_;
    std::vector<State> states_;                       ///< per tile
    std::vector<uint64_t> usedAt_;                    ///< per slot: the update that wanted it last
    std::vector<uint32_t> free_;                      ///< slots
    std::vector<uint8_t> isKept_;                     ///< per slot
    std::unordered_map<uint32_t, Failure> failures_;  ///< by tile
    size_t room_ = 0;
    int attempts_ = 0;       ///< at a tile of who waits for it
    int mostDoublings_ = 0;  ///< of the delay until a tile is tried again
    int named_ = 0;          ///< tiles whose failure was told
    uint64_t now_ = 0;
    StreamFigures figures_;
    TileLoader loader_;  ///< last: its threads end before what they write to
};

}  // namespace terray
