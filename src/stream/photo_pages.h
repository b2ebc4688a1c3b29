// SPDX-License-Identifier: Apache-2.0
// A photo in memory by blocks: those that pictures want come and go; the coarsest mips stay.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stream/slot_keeper.h"
#include "tile/photo_blocks.h"

namespace terray {

/// The page table as sampling reads it. Blocks are numbered: those of mip 0 row by row, then those
/// of mip 1, and so on.
struct PhotoPages {
    struct Mip {
        int width = 0, height = 0;  ///< pixels
        int blocksX = 0, blocksY = 0;
        uint32_t first = 0;  ///< number of its first block
    };
    std::vector<Mip> mips;        ///< all but the coarsest, which is one block
    std::vector<uint32_t> slots;  ///< per block; kNoSlot if it is not there
    const uint8_t* pixels = nullptr;
    size_t slotCount = 0;

    /// 512 x 512 pixels, 4 bytes each; null if it is not there.
    const uint8_t* block(uint32_t number) const;
    size_t mipOf(uint32_t number) const;
};

/// What sampling has used of a photo. confined.
struct PhotoUse {
    std::vector<uint8_t> touched;   ///< per slot: 1 if it was read
    std::vector<uint32_t> missing;  ///< blocks that a coarser one stood in for; may hold doubles
    uint64_t misses = 0;            ///< places read where one did
    uint64_t lateSamples = 0;       ///< samples with such a place

    /// Forgets all, for a pool of so many slots.
    void clear(size_t slots);
    void miss(uint32_t number) {
        ++misses;
        if (missing.empty() || missing.back() != number) missing.push_back(number);
        if (missing.size() >= mostMissing_) removeDoubles();
    }
    /// Adds what another one of the same slots has.
    void add(const PhotoUse& other);

private:
    void removeDoubles();
    size_t mostMissing_ = 4096;
};

/// Changes the page table, so nobody may sample while it is called. confined.
class ResidentPhoto {
public:
    /// Reads the coarsest mips. The others share `maxBytes`, or less where all of them take less.
    static Result<std::unique_ptr<ResidentPhoto>> open(std::unique_ptr<PhotoBlockSource> source,
                                                       uint64_t maxBytes, int threads);
    ~ResidentPhoto();

    const PhotoPages& pages() const { return pages_; }
    const PhotoGrid& grid() const { return grid_; }
    const Affine2& worldFromPixel() const { return source_->worldFromPixel(); }
    const std::string& description() const { return source_->description(); }
    /// Pixels of the coarsest mip, row by row.
    std::span<const uint8_t> coarsest() const { return coarsest_; }
    uint64_t residentBytes() const;
    /// Blocks that a picture may want at a time.
    size_t room() const { return keeper_->room(); }
    bool holdsAll() const { return pages_.slotCount == pages_.slots.size(); }

    /// Which blocks were used: those that are there, and those that are missing; coarse ones first.
    std::vector<uint32_t> blocksOf(const PhotoUse& use) const;
    /// The coarser blocks over some: stand-ins while those are on their way. Coarse ones first.
    std::vector<uint32_t> withCoarser(std::span<const uint32_t> blocks) const;

    /// As SlotKeeper's.
    size_t update(std::span<const uint32_t> wanted, std::span<const uint32_t> soon = {}) {
        return keeper_->update(wanted, soon);
    }
    Result<void> bring(std::span<const uint32_t> wanted) { return keeper_->bring(wanted); }
    const StreamFigures& figures() const { return keeper_->figures(); }

private:
    explicit ResidentPhoto(std::unique_ptr<PhotoBlockSource> source);
    void layOut(uint64_t maxBytes);
    Result<void> readCoarsest();
    Result<void> readKept();
    uint32_t coarserOf(uint32_t number) const;

    std::unique_ptr<PhotoBlockSource> source_;
    PhotoGrid grid_;
    PhotoPages pages_;
    std::vector<uint8_t> coarsest_;
    std::unique_ptr<uint8_t[]> pool_;     ///< memory that is not written to costs none
    std::vector<uint32_t> holders_;       ///< per slot: its block
    std::unique_ptr<SlotKeeper> keeper_;  ///< last: ends before what it writes to
};

}  // namespace terray
