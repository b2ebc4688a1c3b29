// SPDX-License-Identifier: Apache-2.0
// Blocks of a photo come, stay while they are wanted, and make room; damaged ones are tried again.
#include "stream/photo_pages.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "kernel/layout/layout.h"
#include "stream/test_photo.h"

namespace terray {
namespace {

using test::ArrayPhoto;

struct Opened {
    std::shared_ptr<ArrayPhoto::Troubles> troubles = std::make_shared<ArrayPhoto::Troubles>();
    ArrayPhoto same;
    std::unique_ptr<ResidentPhoto> photo;
    Opened(int columns, int rows, size_t blocks) : same(columns, rows, troubles) {
        auto made =
            ResidentPhoto::open(std::make_unique<ArrayPhoto>(same), blocks * kPhotoBlockBytes, 2);
        if (made) photo = std::move(*made);
    }
    /// A block's pixels are the array's.
    void expectRight(uint32_t number) const {
        const PhotoPages& pages = photo->pages();
        const size_t mip = pages.mipOf(number);
        const PhotoPages::Mip& of = pages.mips[mip];
        const int index = static_cast<int>(number - of.first);
        const int left = index % of.blocksX * kPhotoBlockSide;
        const int top = index / of.blocksX * kPhotoBlockSide;
        const uint8_t* block = pages.block(number);
        ASSERT_NE(block, nullptr);
        const int right = std::min(kPhotoBlockSide, of.width - left);
        for (int row = 0; row < std::min(kPhotoBlockSide, of.height - top); row += 7) {
            const size_t at = (static_cast<size_t>(top + row) * static_cast<size_t>(of.width) +
                               static_cast<size_t>(left)) *
                              4;
            ASSERT_TRUE(std::equal(block + row * kPhotoBlockSide * 4,
                                   block + (row * kPhotoBlockSide + right) * 4,
                                   same.pixels(static_cast<int>(mip)).data() + at));
        }
    }
};

TEST(ResidentPhoto, HoldsWhatIsWantedAndNeverMoreThanItsSlots) {
    const Opened of(2700, 2100, 24);
    ASSERT_NE(of.photo, nullptr);
    const PhotoPages& pages = of.photo->pages();
    ASSERT_EQ(pages.slotCount, 24u);
    ASSERT_FALSE(of.photo->holdsAll());
    std::mt19937 random(3);
    for (int round = 0; round < 25; ++round) {
        std::set<uint32_t> some;
        while (some.size() < of.photo->room())
            some.insert(static_cast<uint32_t>(random() % pages.slots.size()));
        const std::vector<uint32_t> wanted(some.begin(), some.end());
        ASSERT_TRUE(of.photo->bring(wanted).ok());
        for (const uint32_t number : wanted) of.expectRight(number);
        std::set<uint32_t> slots;
        for (const uint32_t slot : pages.slots)
            EXPECT_TRUE(slot == kNoSlot || slots.insert(slot).second);
        EXPECT_LE(slots.size(), pages.slotCount);
    }
    const StreamFigures& figures = of.photo->figures();
    EXPECT_GT(figures.evicted, 50u);
    EXPECT_EQ(figures.bytesRead, 1000 * figures.loaded);
    EXPECT_LE(figures.latency.quantile(0.5), figures.latency.quantile(0.99));
    EXPECT_GT(figures.latency.quantile(0.5), 0);
}

TEST(ResidentPhoto, CoarseMipsStayAndStandOverEveryBlock) {
    const Opened of(2700, 2100, 24);
    ASSERT_NE(of.photo, nullptr);
    const PhotoPages& pages = of.photo->pages();
    const PhotoPages::Mip& coarse = pages.mips.back();
    for (auto number = coarse.first; number < pages.slots.size(); ++number) of.expectRight(number);
    for (uint32_t number = 0; number < pages.slots.size(); ++number) {
        const std::vector<uint32_t> chain = of.photo->withCoarser(std::span(&number, 1));
        EXPECT_EQ(chain.size(), pages.mips.size() - pages.mipOf(number));
        EXPECT_EQ(chain.back(), number);
        EXPECT_TRUE(std::is_sorted(chain.begin(), chain.end(), std::greater<>()));
        const int index = static_cast<int>(number), across = pages.mips[0].blocksX;
        if (pages.mipOf(number) > 0) continue;
        const PhotoPages::Mip& next = pages.mips[1];
        const int above =
            static_cast<int>(next.first) + index / across / 2 * next.blocksX + index % across / 2;
        EXPECT_EQ(chain[chain.size() - 2], static_cast<uint32_t>(above));
    }
}

TEST(ResidentPhoto, WhatIsWantedSoonNeverDisplacesWhatIsWanted) {
    const Opened of(2700, 2100, 24);
    ASSERT_NE(of.photo, nullptr);
    std::vector<uint32_t> wanted, soon;
    for (uint32_t k = 0; k < of.photo->room(); ++k) {
        wanted.push_back(k);
        if (k < 20 - 8) soon.push_back(20 + k);
    }
    ASSERT_TRUE(of.photo->bring(soon).ok());
    ASSERT_TRUE(of.photo->bring(wanted).ok());
    for (int k = 0; k < 20; ++k) {
        EXPECT_EQ(of.photo->update(wanted, soon), 0u);
        std::this_thread::yield();
    }
    for (const uint32_t number : wanted) EXPECT_NE(of.photo->pages().slots[number], kNoSlot);
    const std::vector<uint32_t> few{0, 1};
    while (of.photo->pages().slots[soon.back()] == kNoSlot) of.photo->update(few, soon);
    EXPECT_NE(of.photo->pages().slots[0], kNoSlot);
}

TEST(ResidentPhoto, BrokenBlocksAreTriedAgainAndThenNamed) {
    const Opened of(2700, 2100, 24);
    ASSERT_NE(of.photo, nullptr);
    const std::vector<uint32_t> wanted{3, 11};
    of.troubles->failures = 2;
    EXPECT_TRUE(of.photo->bring(wanted).ok());
    of.troubles->failures = 1000;
    const std::vector<uint32_t> other{17};
    const auto failed = of.photo->bring(other);
    ASSERT_FALSE(failed.ok());
    EXPECT_NE(failed.error().message.find("is broken"), std::string::npos);
    of.troubles->failures = 0;
    while (of.photo->update(other) > 0) std::this_thread::yield();
    of.expectRight(17);
}

TEST(ResidentPhoto, ASmallPhotoIsOneBlockThatStays) {
    const Opened of(300, 500, 1);
    ASSERT_NE(of.photo, nullptr);
    EXPECT_TRUE(of.photo->holdsAll());
    EXPECT_TRUE(of.photo->pages().mips.empty());
    EXPECT_EQ(of.photo->coarsest().size(), 300u * 500u * 4u);
}

TEST(LatencyFigures, QuantilesAreGoodToAFewPercent) {
    LatencyFigures figures;
    EXPECT_EQ(figures.quantile(0.5), 0);
    for (int k = 1; k <= 1000; ++k) figures.add(0.1 * k);
    EXPECT_NEAR(figures.quantile(0.5), 50, 2.5);
    EXPECT_NEAR(figures.quantile(0.99), 99, 5);
    figures.add(1e12);
    EXPECT_GT(figures.quantile(1), 100);
}

}  // namespace
}  // namespace terray
