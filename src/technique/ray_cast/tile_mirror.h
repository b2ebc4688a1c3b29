// SPDX-License-Identifier: Apache-2.0
// The tiles and tables of a cut in the memory of a Vulkan device.
#pragma once

#include <map>
#include <vector>

#include "device/vulkan/uploader.h"
#include "kernel/layout/layout.h"

namespace terray {

/// Tiles of one terrain; those that a picture draws stay until others need their room. confined.
class TileMirror {
public:
    /// Both must outlive the mirror.
    TileMirror(vulkan::Device& device, vulkan::Uploader& uploader)
        : device_(device), uploader_(uploader) {}

    /// Uploads what the cut draws and is not there yet, and its tables. Error Resource if the drawn
    /// tiles do not fit.
    Result<void> bring(const TerrainCut& cut);

    const vulkan::Buffer& header() const { return header_; }    ///< TraceCut and levels
    const vulkan::Buffer& squares() const { return squares_; }  ///< as in the cut
    const vulkan::Buffer& tiles() const { return tiles_; }      ///< per slot of the CPU's pool

private:
    struct Key {
        int32_t mip, x, y;
        auto operator<=>(const Key&) const = default;
    };
    struct Slot {
        size_t chunk = 0;
        uint64_t byte = 0;  ///< in the chunk
    };
    struct Place {
        Slot slot;
        uint64_t drawn = 0;  ///< the picture that drew it last
    };
    static Key keyOf(const TileDesc& tile);
    uint64_t slotBytes() const;
    uint64_t addressOf(const Slot& slot) const { return chunks_[slot.chunk].address() + slot.byte; }
    Result<Slot> freeSlot();
    /// Of a few slots, fewer where there is less memory.
    Result<void> addChunk();
    /// The least recently drawn tile that this picture does not draw gives up its slot.
    bool evict();
    Result<void> bringTile(const TerrainCut& cut, const TileDesc& tile, Place& place);
    Result<void> bringTables(const TerrainCut& cut, size_t squareCount,
                             std::span<const TileDesc> tiles);
    Result<void> put(std::span<const std::byte> bytes, vulkan::Buffer& to);

    vulkan::Device& device_;
    vulkan::Uploader& uploader_;
    vulkan::Buffer header_, squares_, tiles_;
    uint64_t postBytes_ = 0;  ///< of a tile
    std::vector<vulkan::Buffer> chunks_;
    std::vector<Slot> free_;
    std::map<Key, Place> places_;
    uint64_t picture_ = 0;
};

}  // namespace terray
