// SPDX-License-Identifier: Apache-2.0
// Slots of tiles in chunks of device memory.
#include "technique/ray_cast/tile_mirror.h"

#include <algorithm>
#include <set>

#include "kernel/device_rays.h"

namespace terray {
namespace {

constexpr uint64_t kChunkBytes = uint64_t{16} << 20;
constexpr uint64_t kAlign = 64;  ///< of posts and pyramids, bytes
constexpr uint64_t kBoundBytes = (uint64_t{kSlotBounds} * 4 + kAlign - 1) / kAlign * kAlign;

uint64_t bytesPerPost(const TerrainCut& cut) { return cut.format == 1 ? 4 : 2; }

size_t squareCountOf(const TerrainCut& cut) {
    size_t count = 0;
    for (int level = 0; level <= cut.rootLevel; ++level) {
        const DirectoryLevel& d = cut.levels[level];
        count = std::max(count, d.offset + size_t{d.columns} * d.rows);
    }
    return count;
}

std::span<const std::byte> bytesOf(const void* from, size_t count) {
    return {static_cast<const std::byte*>(from), count};
}

}  // namespace

TileMirror::Key TileMirror::keyOf(const TileDesc& tile) {
    return {static_cast<int32_t>(tile.mipFlags & kTileMipMask), tile.x, tile.y};
}

uint64_t TileMirror::slotBytes() const {
    return (postBytes_ + kAlign - 1) / kAlign * kAlign + kBoundBytes;
}

Result<void> TileMirror::addChunk() {
    for (size_t slots = std::max<uint64_t>(kChunkBytes / slotBytes(), 1);; slots /= 2) {
        auto chunk = device_.makeBuffer(slots * slotBytes(), vulkan::MemoryKind::Device);
        if (!chunk && slots > 1 && !device_.isLost()) continue;
        if (!chunk) return chunk.error();
        for (size_t k = slots; k-- > 0;) free_.push_back({chunks_.size(), k * slotBytes()});
        chunks_.push_back(std::move(*chunk));
        return {};
    }
}

bool TileMirror::evict() {
    const auto least = std::min_element(
        places_.begin(), places_.end(),
        [](const auto& a, const auto& b) { return a.second.drawn < b.second.drawn; });
    if (least == places_.end() || least->second.drawn == picture_) return false;
    free_.push_back(least->second.slot);
    places_.erase(least);
    return true;
}

Result<TileMirror::Slot> TileMirror::freeSlot() {
    if (free_.empty()) {
        if (const auto added = addChunk(); !added && (device_.isLost() || !evict()))
            return added.error();
    }
    const Slot slot = free_.back();
    free_.pop_back();
    return slot;
}

Result<void> TileMirror::bringTile(const TerrainCut& cut, const TileDesc& tile, Place& place) {
    const auto slot = freeSlot();
    if (!slot) return slot.error();
    place.slot = *slot;
    const vulkan::Buffer& chunk = chunks_[slot->chunk];
    const auto* posts = static_cast<const std::byte*>(cut.posts) + tile.posts * bytesPerPost(cut);
    TERRAY_TRY(uploader_.put(bytesOf(posts, postBytes_), chunk, slot->byte));
    return uploader_.put(bytesOf(cut.bounds + tile.bounds, size_t{kSlotBounds} * 4), chunk,
                         slot->byte + slotBytes() - kBoundBytes);
}

Result<void> TileMirror::bring(const TerrainCut& cut) {
    ++picture_;
    postBytes_ = uint64_t{kSlotPosts} * bytesPerPost(cut);
    std::set<uint32_t> drawn;
    const size_t squareCount = squareCountOf(cut);
    for (size_t k = 0; k < squareCount; ++k)
        if (cut.squares[k].state == kSquareDrawn) drawn.insert(cut.squares[k].slot);
    // First those that are there, so that none of them is evicted for another.
    for (const uint32_t slot : drawn) {
        const auto found = places_.find(keyOf(cut.tiles[slot]));
        if (found != places_.end()) found->second.drawn = picture_;
    }
    std::vector<TileDesc> tiles(cut.tiles, cut.tiles + cut.tileCount);
    for (const uint32_t slot : drawn) {
        TileDesc& tile = tiles[slot];
        auto found = places_.find(keyOf(tile));
        if (found == places_.end()) {
            Place place{{}, picture_};
            if (const auto brought = bringTile(cut, tile, place); !brought) {
                if (device_.isLost()) return brought.error();
                return makeError(ErrorCode::Resource,
                                 "--device vulkan: this picture draws {} tiles of {:.2f} MiB, too "
                                 "many for the device ({}); raise --tolerance, or use --device cpu",
                                 drawn.size(), static_cast<double>(slotBytes()) / 1048576.0,
                                 brought.error().message);
            }
            found = places_.emplace(keyOf(tile), place).first;
        }
        tile.posts = addressOf(found->second.slot);
        tile.bounds = tile.posts + slotBytes() - kBoundBytes;
    }
    return bringTables(cut, squareCount, tiles);
}

Result<void> TileMirror::bringTables(const TerrainCut& cut, size_t squareCount,
                                     std::span<const TileDesc> tiles) {
    struct Header {
        TraceCut cut;
        DirectoryLevel levels[kMaxLevels];
    } header{traceCutOf(cut), {}};
    std::copy(std::begin(cut.levels), std::end(cut.levels), header.levels);
    TERRAY_TRY(put(bytesOf(&header, sizeof(header)), header_));
    TERRAY_TRY(put(bytesOf(cut.squares, squareCount * sizeof(Square)), squares_));
    TERRAY_TRY(put(std::as_bytes(tiles), tiles_));
    return uploader_.flush();
}

/// Into a buffer that grows when it must. Nothing of an earlier picture is running any more.
Result<void> TileMirror::put(std::span<const std::byte> bytes, vulkan::Buffer& to) {
    if (to.bytes() < bytes.size()) {
        TERRAY_TRY(uploader_.flush());
        TERRAY_TRY(device_.waitIdle());
        auto made = device_.makeBuffer(bytes.size(), vulkan::MemoryKind::Device);
        if (!made) return made.error();
        to = std::move(*made);
    }
    return uploader_.put(bytes, to, 0);
}

}  // namespace terray
