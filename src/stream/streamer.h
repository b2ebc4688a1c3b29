// SPDX-License-Identifier: Apache-2.0
// Which tiles of a source are resident: what frames want is loaded, what they wanted longest ago
// makes room for it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "stream/pool.h"
#include "stream/slot_keeper.h"
#include "tile/tile_source.h"

namespace terray {

/// Changes the pool's page table, so no frame may be drawn while it is called. confined.
class Streamer {
public:
    /// Loads the mips that stay; they must fit.
    static Result<std::unique_ptr<Streamer>> make(const TileSource& source,
                                                  ResidentTerrain::Pool& pool, int threads);

    /// Slots for tiles of finer mips than those that stay.
    size_t room() const { return keeper_.room(); }
    /// True if there is a slot for each of the tiles.
    bool fits(std::span<const TileId> tiles) const;

    /// Shows the tiles that have arrived and asks for the wanted ones that are absent, the first
    /// ones first, then for those that will be wanted soon. Returns at once; the number of wanted
    /// tiles that are absent.
    size_t update(std::span<const TileId> wanted, std::span<const TileId> soon = {});

    /// The same until all wanted tiles are there. They must fit. What cannot
    /// be read is tried again a few times; then the error of such a tile (the others are there).
    /// Interrupted.
    Result<void> bring(std::span<const TileId> wanted);

    const StreamFigures& figures() const { return keeper_.figures(); }
    /// Changes whenever what is resident does.
    uint64_t version() const { return figures().loaded + figures().evicted; }

private:
    Streamer(const TileSource& source, ResidentTerrain::Pool& pool, int threads);
    SlotHooks hooks(const TileSource& source);
    void makeRims(std::span<const uint32_t> shown);
    std::vector<uint32_t> numbersOf(std::span<const TileId> tiles) const;

    ResidentTerrain::Pool& pool_;
    SlotKeeper keeper_;
};

}  // namespace terray
