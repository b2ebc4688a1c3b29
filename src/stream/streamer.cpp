// SPDX-License-Identifier: Apache-2.0
// Tiles of heights in slots: reading them, and what follows from their neighbours.
#include "stream/streamer.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <type_traits>

#include "base/assert.h"
#include "stream/slot.h"

namespace terray {
namespace {

constexpr TileId kNoTile{-1, 0, 0};

class TileFiller final : public SlotFiller {
public:
    TileFiller(std::unique_ptr<TileReader> reader, ResidentTerrain::Pool& pool)
        : reader_(std::move(reader)), pool_(pool) {}

    Result<void> fill(const SlotJob& job) override {
        TERRAY_TRY(pool_.format == PostFormat::Int16 ? read(job, pool_.postsOf<uint16_t>(job.slot))
                                                     : read(job, pool_.postsOf<float>(job.slot)));
        makePyramid(pool_, job.slot);
        return {};
    }
    uint64_t bytesRead() const override { return reader_->bytesRead(); }

private:
    template <class Post>
    Result<void> read(const SlotJob& job, Post* posts) {
        const TileId id = pool_.tileOf(job.number);
        const bool isFull = pool_.cellsX(id) == kTileCells && pool_.cellsY(id) == kTileCells;
        if (!isFull) std::fill_n(posts, size_t{kSlotPosts}, Post{0});
        if constexpr (std::is_same_v<Post, float>)
            return reader_->read(id, posts, kPostStride);
        else
            return reader_->readCodes(id, posts, kPostStride);
    }

    std::unique_ptr<TileReader> reader_;
    ResidentTerrain::Pool& pool_;
};

MakeFiller tileFillers(const TileSource& source, ResidentTerrain::Pool& pool) {
    return [&source, &pool]() -> Result<std::unique_ptr<SlotFiller>> {
        auto reader = source.makeReader();
        if (!reader) return reader.error();
        return std::unique_ptr<SlotFiller>(new TileFiller(std::move(*reader), pool));
    };
}

}  // namespace

SlotHooks Streamer::hooks(const TileSource& source) {
    return {[this](uint32_t slot, uint32_t number) { pool_.assign(slot, pool_.tileOf(number)); },
            [this](uint32_t slot) { pool_.ids[slot] = kNoTile; },
            [this](std::span<const uint32_t> numbers) { makeRims(numbers); },
            [&source] { source.stopReading(); }, "tile"};
}

Streamer::Streamer(const TileSource& source, ResidentTerrain::Pool& pool, int threads)
    : pool_(pool),
      keeper_(pool.slots, static_cast<uint32_t>(pool.tiles.size()), hooks(source),
              tileFillers(source, pool), threads,
              source.isRemote() ? kPatienceWithServers : Patience{}) {}

Result<std::unique_ptr<Streamer>> Streamer::make(const TileSource& source,
                                                 ResidentTerrain::Pool& pool, int threads) {
    std::unique_ptr<Streamer> streamer(new Streamer(source, pool, threads));
    std::vector<uint32_t> kept;
    for (uint32_t number = pool.firstTile[static_cast<size_t>(pool.firstKept)];
         number < pool.slots.size(); ++number) {
        if (!pool.isHollow(number)) kept.push_back(number);
    }
    std::reverse(kept.begin(), kept.end());  // coarse ones first
    TERRAY_ASSERT(kept.size() <= streamer->room());
    TERRAY_TRY(streamer->keeper_.bring(kept));
    streamer->keeper_.keep(kept);
    return streamer;
}

bool Streamer::fits(std::span<const TileId> tiles) const {
    const auto comes = [&](TileId id) { return id.mip < pool_.firstKept; };
    return static_cast<size_t>(std::count_if(tiles.begin(), tiles.end(), comes)) <= room();
}

/// Of those that there is something to load of.
std::vector<uint32_t> Streamer::numbersOf(std::span<const TileId> tiles) const {
    std::vector<uint32_t> numbers;
    numbers.reserve(tiles.size());
    for (const TileId id : tiles) {
        const uint32_t number = pool_.numberOf(id);
        if (!pool_.isHollow(number)) numbers.push_back(number);
    }
    return numbers;
}

size_t Streamer::update(std::span<const TileId> wanted, std::span<const TileId> soon) {
    return keeper_.update(numbersOf(wanted), numbersOf(soon));
}

Result<void> Streamer::bring(std::span<const TileId> wanted) {
    return keeper_.bring(numbersOf(wanted));
}

/// Sharpness at the rims of the new tiles and of their neighbours follows from both.
void Streamer::makeRims(std::span<const uint32_t> shown) {
    constexpr int kSteps[][2] = {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}};
    std::vector<uint32_t> slots;
    for (const uint32_t number : shown) {
        const TileId id = pool_.tileOf(number);
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

}  // namespace terray
