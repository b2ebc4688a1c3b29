// SPDX-License-Identifier: Apache-2.0
// Threads that need a sweep that is being made help to make it.
#include "kernel/sweep/sun_cache.h"

#include <oneapi/tbb/collaborative_call_once.h>

#include <algorithm>
#include <iterator>

namespace terray {

namespace {

/// A slot may hold another tile in the next frame.
struct DrawnTile {
    uint32_t slot, mip;
    int32_t x, y;
    friend bool operator==(const DrawnTile&, const DrawnTile&) = default;
};

std::vector<DrawnTile> drawnTiles(const TerrainCut& cut) {
    std::vector<DrawnTile> drawn;
    for (const uint32_t slot : drawnSlots(cut)) {
        const TileDesc& tile = cut.tiles[slot];
        drawn.push_back({slot, tile.mipFlags & kTileMipMask, tile.x, tile.y});
    }
    return drawn;
}

}  // namespace

struct SunSweepCache::Entry {
    SunDirection sun;
    const void* posts = nullptr;
    SurfaceKind surface = kSurfaceBilinear;
    std::vector<DrawnTile> drawn;
    oneapi::tbb::collaborative_once_flag once;
    std::shared_ptr<const SunSweep> sweep;

    uint64_t bytes() const { return SunSweep::bytesFor(drawn.size()); }
};

std::shared_ptr<SunSweepCache::Entry> SunSweepCache::entryFor(const TerrainCut& cut,
                                                              const SunDirection& sun) {
    std::vector<DrawnTile> drawn = drawnTiles(cut);
    const SurfaceKind surface = cut.surface;
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const auto& entry) {
        return entry->sun == sun && entry->posts == cut.posts && entry->surface == surface &&
               entry->drawn == drawn;
    });
    if (found != entries_.end()) {
        entries_.splice(entries_.begin(), entries_, found);
        return entries_.front();
    }
    auto entry = std::make_shared<Entry>();
    entry->sun = sun;
    entry->posts = cut.posts;
    entry->surface = surface;
    entry->drawn = std::move(drawn);
    entries_.push_front(entry);
    uint64_t bytes = entry->bytes();
    const auto rest =
        std::find_if(std::next(entries_.begin()), entries_.end(),
                     [&](const auto& kept) { return (bytes += kept->bytes()) > mostBytes_; });
    entries_.erase(rest, entries_.end());
    return entry;
}

std::shared_ptr<const SunSweep> SunSweepCache::get(const TerrainCut& cut, const SunDirection& sun) {
    const std::shared_ptr<Entry> entry = entryFor(cut, sun);
    oneapi::tbb::collaborative_call_once(entry->once,
                                         [&] { entry->sweep = SunSweep::make(cut, sun); });
    return entry->sweep;
}

}  // namespace terray
