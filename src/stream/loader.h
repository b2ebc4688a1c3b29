// SPDX-License-Identifier: Apache-2.0
// Reads tiles into slots on threads of its own, the first of a list first.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "stream/pool.h"
#include "tile/tile_source.h"

namespace terray {

/// A tile and the slot that it goes into. The slot is the loader's until the tile is taken.
struct TileJob {
    TileId id;
    uint32_t slot = kNoSlot;
};
struct LoadedTile {
    TileJob job;
    Result<void> outcome;  ///< with posts and pyramid in the slot, or why not
};

/// synchronised.
class TileLoader {
public:
    TileLoader(const TileSource& source, ResidentTerrain::Pool& pool, int threads);
    /// Stops the source, and waits for what is being read.
    ~TileLoader();
    TileLoader(const TileLoader&) = delete;
    TileLoader& operator=(const TileLoader&) = delete;

    void ask(const TileJob& job);
    /// Takes back what no thread has begun with.
    std::vector<TileJob> takeBack();
    /// What is done. With nothing done, waits for something for up to `most`.
    std::vector<LoadedTile> take(std::chrono::milliseconds most);

private:
    void work();
    Result<void> load(TileReader& reader, const TileJob& job);

    const TileSource& source_;
    ResidentTerrain::Pool& pool_;
    std::mutex mutex_;
    std::condition_variable asked_, done_;
    std::deque<TileJob> jobs_;
    std::vector<LoadedTile> loaded_;
    int busy_ = 0;  ///< threads that read
    bool stop_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace terray
