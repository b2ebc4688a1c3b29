// SPDX-License-Identifier: Apache-2.0
// Numbers of blocks, the pool that they come into, and what stays.
#include "stream/photo_pages.h"

#include <algorithm>

#include "base/assert.h"
#include "kernel/layout/layout.h"

namespace terray {
namespace {

constexpr size_t kLeastSlots = 24;  ///< what a piece of any picture takes, and the mips that stay
constexpr size_t kMostKept = 8;     ///< blocks that stay

class BlockFiller final : public SlotFiller {
public:
    BlockFiller(std::unique_ptr<PhotoBlockReader> reader, const PhotoPages& pages, uint8_t* pool)
        : reader_(std::move(reader)), pages_(pages), pool_(pool) {}
    Result<void> fill(const SlotJob& job) override {
        const size_t mip = pages_.mipOf(job.number);
        const PhotoPages::Mip& of = pages_.mips[mip];
        const int index = static_cast<int>(job.number - of.first);
        return reader_->read(static_cast<int>(mip), index % of.blocksX, index / of.blocksX,
                             pool_ + job.slot * kPhotoBlockBytes);
    }
    uint64_t bytesRead() const override { return reader_->bytesRead(); }

private:
    std::unique_ptr<PhotoBlockReader> reader_;
    const PhotoPages& pages_;
    uint8_t* pool_;
};

}  // namespace

const uint8_t* PhotoPages::block(uint32_t number) const {
    const uint32_t slot = slots[number];
    return slot == kNoSlot ? nullptr : pixels + slot * kPhotoBlockBytes;
}

size_t PhotoPages::mipOf(uint32_t number) const {
    const auto after =
        std::upper_bound(mips.begin(), mips.end(), number,
                         [](uint32_t value, const Mip& mip) { return value < mip.first; });
    return static_cast<size_t>(after - mips.begin()) - 1;
}

void PhotoUse::clear(size_t slots) {
    touched.assign(slots, 0);
    missing.clear();
    misses = lateSamples = 0;
    mostMissing_ = 4096;
}

void PhotoUse::removeDoubles() {
    std::sort(missing.begin(), missing.end());
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    mostMissing_ = std::max(mostMissing_, 2 * missing.size());
}

void PhotoUse::add(const PhotoUse& other) {
    TERRAY_ASSERT(touched.size() == other.touched.size());
    for (size_t slot = 0; slot < touched.size(); ++slot) touched[slot] |= other.touched[slot];
    missing.insert(missing.end(), other.missing.begin(), other.missing.end());
    removeDoubles();
    misses += other.misses;
    lateSamples += other.lateSamples;
}

ResidentPhoto::ResidentPhoto(std::unique_ptr<PhotoBlockSource> source)
    : source_(std::move(source)), grid_(source_->grid()) {}
ResidentPhoto::~ResidentPhoto() = default;

void ResidentPhoto::layOut(uint64_t maxBytes) {
    uint32_t blocks = 0;
    for (int mip = 0; mip + 1 < grid_.mipCount(); ++mip) {
        const int blocksX = grid_.blocksX(mip), blocksY = grid_.blocksY(mip);
        pages_.mips.push_back({static_cast<int>(grid_.columnsAt(mip)),
                               static_cast<int>(grid_.rowsAt(mip)), blocksX, blocksY, blocks});
        blocks += static_cast<uint32_t>(blocksX) * static_cast<uint32_t>(blocksY);
    }
    pages_.slots.assign(blocks, kNoSlot);
    pages_.slotCount =
        std::min<size_t>(std::max<size_t>(maxBytes / kPhotoBlockBytes, kLeastSlots), blocks);
    pool_ = std::make_unique_for_overwrite<uint8_t[]>(pages_.slotCount * kPhotoBlockBytes);
    pages_.pixels = pool_.get();
    holders_.assign(pages_.slotCount, kNoSlot);
}

Result<std::unique_ptr<ResidentPhoto>> ResidentPhoto::open(std::unique_ptr<PhotoBlockSource> source,
                                                           uint64_t maxBytes, int threads) {
    std::unique_ptr<ResidentPhoto> photo(new ResidentPhoto(std::move(source)));
    photo->layOut(maxBytes);
    TERRAY_TRY(photo->readCoarsest());
    ResidentPhoto* const self = photo.get();
    SlotHooks hooks{[self](uint32_t slot, uint32_t number) { self->holders_[slot] = number; },
                    [self](uint32_t slot) { self->holders_[slot] = kNoSlot; },
                    [](std::span<const uint32_t>) {}, [] {}, "block"};
    const MakeFiller makeFiller = [self]() -> Result<std::unique_ptr<SlotFiller>> {
        auto reader = self->source_->makeReader();
        if (!reader) return reader.error();
        return std::unique_ptr<SlotFiller>(
            new BlockFiller(std::move(*reader), self->pages_, self->pool_.get()));
    };
    photo->keeper_ = std::make_unique<SlotKeeper>(photo->pages_.slots,
                                                  static_cast<uint32_t>(photo->pages_.slotCount),
                                                  std::move(hooks), makeFiller, threads);
    TERRAY_TRY(photo->readKept());
    return photo;
}

Result<void> ResidentPhoto::readCoarsest() {
    auto reader = source_->makeReader();
    if (!reader) return reader.error();
    const int mip = grid_.mipCount() - 1;
    std::vector<uint8_t> block(kPhotoBlockBytes);
    TERRAY_TRY((*reader)->read(mip, 0, 0, block.data()));
    const auto width = static_cast<size_t>(grid_.columnsAt(mip)) * 4;
    const auto height = static_cast<size_t>(grid_.rowsAt(mip));
    coarsest_.resize(width * height);
    for (size_t row = 0; row < height; ++row)
        std::copy_n(block.data() + row * kPhotoBlockSide * 4, width,
                    coarsest_.data() + row * width);
    return {};
}

Result<void> ResidentPhoto::readKept() {
    auto first = static_cast<uint32_t>(pages_.slots.size());
    for (auto mip = pages_.mips.rbegin(); mip != pages_.mips.rend(); ++mip)
        if (pages_.slots.size() - mip->first <= kMostKept) first = mip->first;
    std::vector<uint32_t> kept;
    for (auto number = static_cast<uint32_t>(pages_.slots.size()); number > first; --number)
        kept.push_back(number - 1);
    TERRAY_TRY(keeper_->bring(kept));
    keeper_->keep(kept);
    return {};
}

uint64_t ResidentPhoto::residentBytes() const {
    return pages_.slotCount * kPhotoBlockBytes + pages_.slots.size() * sizeof(uint32_t) +
           coarsest_.size();
}

/// kNoSlot over the last mip of the table.
uint32_t ResidentPhoto::coarserOf(uint32_t number) const {
    const size_t mip = pages_.mipOf(number);
    if (mip + 1 == pages_.mips.size()) return kNoSlot;
    const PhotoPages::Mip &fine = pages_.mips[mip], &coarse = pages_.mips[mip + 1];
    const auto across = static_cast<uint32_t>(fine.blocksX);
    const uint32_t x = (number - fine.first) % across, y = (number - fine.first) / across;
    return coarse.first + y / 2 * static_cast<uint32_t>(coarse.blocksX) + x / 2;
}

std::vector<uint32_t> ResidentPhoto::blocksOf(const PhotoUse& use) const {
    std::vector<uint32_t> blocks = use.missing;
    for (size_t slot = 0; slot < use.touched.size(); ++slot)
        if (use.touched[slot] != 0) blocks.push_back(holders_[slot]);
    std::sort(blocks.begin(), blocks.end(), std::greater<>());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    return blocks;
}

std::vector<uint32_t> ResidentPhoto::withCoarser(std::span<const uint32_t> blocks) const {
    std::vector<uint32_t> all(blocks.begin(), blocks.end());
    for (size_t k = 0; k < all.size(); ++k) {
        const uint32_t coarser = coarserOf(all[k]);
        if (coarser != kNoSlot) all.push_back(coarser);
    }
    std::sort(all.begin(), all.end(), std::greater<>());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
}

}  // namespace terray
