// SPDX-License-Identifier: Apache-2.0
// Photo filtering: averages of light, no moire, partial cover.
#include "shade/photo_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "kernel/layout/layout.h"
#include "stream/test_photo.h"

namespace terray {
namespace {

Photo photoOf(int width, int height, const std::function<uint32_t(int, int)>& rgba) {
    Photo photo;
    photo.width = width;
    photo.height = height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int shift = 24; shift >= 0; shift -= 8)
                photo.rgba.push_back(static_cast<uint8_t>(rgba(x, y) >> shift));
    return photo;
}

uint32_t checker(int x, int y) { return (x + y) % 2 ? 0xFFFFFFFFu : 0x000000FFu; }

TEST(PhotoFilter, AtAPixelsCentreGivesThatPixel) {
    const Photo photo = photoOf(9, 7, [](int x, int y) {
        return static_cast<uint32_t>(x * 20) << 24 | static_cast<uint32_t>(y * 30) << 16 | 0x80FFu;
    });
    const PhotoFilter filter(photo);
    const PhotoSample s = filter.at({4, 3}, {0.4f, 0}, {0, 0.4f});
    EXPECT_NEAR(s.colour.r, rules::linearFromSrgb(80 / 255.0f), 1e-5f);
    EXPECT_NEAR(s.colour.g, rules::linearFromSrgb(90 / 255.0f), 1e-5f);
    EXPECT_NEAR(s.cover, 1, 1e-5f);
}

TEST(PhotoFilter, ACheckerboardFromAfarIsHalfTheLight) {
    const Photo photo = photoOf(256, 256, checker);
    const PhotoFilter filter(photo);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> place(40, 215), angle(0, 3.14);
    std::uniform_real_distribution<float> size(4, 20), stretch(1, 8);
    for (int k = 0; k < 2000; ++k) {
        const double turn = angle(random);
        const float minor = size(random), major = minor * stretch(random);
        const glm::vec2 along{std::cos(turn), std::sin(turn)};
        const PhotoSample s = filter.at({place(random), place(random)}, along * major,
                                        glm::vec2{-along.y, along.x} * minor);
        if (s.cover < 0.999f) continue;
        EXPECT_NEAR(s.colour.g, 0.5f, 0.02f);
    }
}

TEST(PhotoFilter, KeepsDetailAcrossTheLongAxisOfAStretchedFootprint) {
    // Stripes along x, 8 pixels wide; a footprint of 32 x 4 pixels along them must keep them apart.
    const Photo photo =
        photoOf(256, 256, [](int, int y) { return (y / 8) % 2 ? 0xFFFFFFFFu : 0x000000FFu; });
    const PhotoFilter filter(photo);
    EXPECT_GT(filter.at({128, 123.5}, {32, 0}, {0, 4}).colour.g, 0.9f);
    EXPECT_LT(filter.at({128, 131.5}, {32, 0}, {0, 4}).colour.g, 0.1f);
}

TEST(PhotoFilter, DoesNotJumpAsTheFootprintGrows) {
    std::mt19937 random(4);
    std::vector<uint32_t> noise(128 * 128);
    for (uint32_t& v : noise) v = static_cast<uint32_t>(random()) | 0xFFu;
    const Photo photo =
        photoOf(128, 128, [&](int x, int y) { return noise[static_cast<size_t>(y * 128 + x)]; });
    const PhotoFilter filter(photo);
    float last = filter.at({64.3, 61.8}, {0.5f, 0}, {0, 0.5f}).colour.r;
    for (float width = 0.5f; width < 40; width *= 1.01f) {
        const float now = filter.at({64.3, 61.8}, {width, 0}, {0, width}).colour.r;
        EXPECT_NEAR(now, last, 0.03f) << width;
        last = now;
    }
}

TEST(PhotoFilter, UncoveredPixelsNeitherDarkenNorCount) {
    const Photo photo =
        photoOf(64, 64, [](int x, int) { return x < 32 ? 0xC08040FFu : 0x00000000u; });
    const PhotoFilter filter(photo);
    const PhotoSample s = filter.at({31.5, 31.5}, {12, 0}, {0, 12});
    EXPECT_NEAR(s.cover, 0.5f, 0.05f);
    EXPECT_NEAR(s.colour.r / s.cover, rules::linearFromSrgb(192 / 255.0f), 0.01f);
    EXPECT_EQ(filter.at({50, 30}, {1, 0}, {0, 1}).cover, 0.0f);
    EXPECT_EQ(filter.at({-40, 30}, {2, 0}, {0, 2}).cover, 0.0f);
}

TEST(PhotoFilter, OddAndTinyPhotosHaveMipsDownToOnePixel) {
    for (auto [w, h] : {std::pair{1, 1}, {1, 7}, {5, 3}, {17, 2}}) {
        const Photo photo = photoOf(w, h, [](int, int) { return 0x808080FFu; });
        const PhotoFilter filter(photo);
        const PhotoSample s = filter.at({w / 2.0 - 0.5, h / 2.0 - 0.5}, {0.1f, 0}, {0, 1.5f});
        EXPECT_NEAR(s.colour.r / s.cover, rules::linearFromSrgb(128 / 255.0f), 0.01f);
    }
}

struct BlocksAndWhole {
    Photo whole;
    std::unique_ptr<ResidentPhoto> blocks;
    BlocksAndWhole(int width, int height, size_t slots) {
        auto source = std::make_unique<test::ArrayPhoto>(width, height);
        whole.width = width;
        whole.height = height;
        whole.rgba = source->pixels(0);
        auto made = ResidentPhoto::open(std::move(source), slots * kPhotoBlockBytes, 1);
        if (made) blocks = std::move(*made);
    }
};

/// Footprints of all sizes and shapes, many of them at borders of blocks.
PhotoFeet someFeet(std::mt19937& random, int width, int height) {
    std::uniform_real_distribution<double> near(-3, 3), angle(0, 6.3), size(-2, 7);
    std::uniform_real_distribution<double> x(-2, width + 1), y(-2, height + 1);
    PhotoFeet feet;
    for (int k = 0; k < kBatch; ++k) {
        feet.x[k] = k % 3 == 0 ? 512 * (1 + k / 3 % 3) + near(random) : x(random);
        feet.y[k] = k % 4 == 0 ? 512 * (1 + k / 4 % 2) + near(random) : y(random);
        const double turn = angle(random), a = std::exp2(size(random)), b = std::exp2(size(random));
        feet.a.x[k] = static_cast<float>(a * std::cos(turn));
        feet.a.y[k] = static_cast<float>(a * std::sin(turn));
        feet.b.x[k] = static_cast<float>(-b * std::sin(turn));
        feet.b.y[k] = static_cast<float>(b * std::cos(turn + 0.3));
    }
    return feet;
}

TEST(PhotoFilter, BlocksOfAPhotoGiveWhatTheWholeGives) {
    const BlocksAndWhole of(3300, 1300, 24);
    ASSERT_NE(of.blocks, nullptr);
    ASSERT_FALSE(of.blocks->pages().slots.empty());
    const PhotoFilter whole(of.whole), inBlocks(*of.blocks);
    EXPECT_EQ(whole.mipCount(), inBlocks.mipCount());
    std::mt19937 random(6);
    size_t missed = 0;
    for (int round = 0; round < 60; ++round) {
        const PhotoFeet feet = someFeet(random, 1700, 1300);
        PhotoBatch expected, first, then;
        PhotoUse none, use;
        whole.prepare(none);
        inBlocks.prepare(use);
        whole.at(feet, expected, none);
        inBlocks.at(feet, first, use);
        const std::vector<uint32_t> blocks = of.blocks->blocksOf(use);
        missed += use.missing.size();
        for (int k = 0; k < kBatch; ++k)
            EXPECT_TRUE(first.late[k] == 1 || first.colour.r[k] == expected.colour.r[k]);
        ASSERT_LE(blocks.size(), of.blocks->room());
        ASSERT_TRUE(of.blocks->bring(blocks).ok());
        inBlocks.prepare(use);
        inBlocks.at(feet, then, use);
        EXPECT_EQ(use.misses, 0u);
        for (int k = 0; k < kBatch; ++k) {
            EXPECT_EQ(then.late[k], 0);
            EXPECT_EQ(then.colour.r[k], expected.colour.r[k]);
            EXPECT_EQ(then.colour.g[k], expected.colour.g[k]);
            EXPECT_EQ(then.colour.b[k], expected.colour.b[k]);
            EXPECT_EQ(then.cover[k], expected.cover[k]);
        }
    }
    EXPECT_GT(missed, 5u);
}

TEST(PhotoFilter, ACoarserBlockStandsInForAMissingOne) {
    const BlocksAndWhole of(2700, 2100, 24);
    ASSERT_NE(of.blocks, nullptr);
    const PhotoFilter filter(*of.blocks);
    PhotoFeet feet{};
    for (int k = 0; k < kBatch; ++k) {
        feet.x[k] = 700.25;
        feet.y[k] = 300.5;
        feet.a.x[k] = feet.b.y[k] = 0.5f;
    }
    PhotoBatch photo;
    PhotoUse use;
    filter.prepare(use);
    filter.at(feet, photo, use);
    EXPECT_EQ(photo.late[0], 1);
    ASSERT_FALSE(use.missing.empty());
    EXPECT_EQ(use.missing[0], 1u);
    EXPECT_GT(photo.cover[0], 0.5f);
    EXPECT_EQ(use.misses, 2u * kBatch);  // mips 0 and 1: the one after that stays
}

}  // namespace
}  // namespace terray
