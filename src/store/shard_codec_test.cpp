// SPDX-License-Identifier: Apache-2.0
// Height files come back as they went in, or within the stated error; bytes depend on posts alone.
#include "store/shard_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace terray {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

TerrainInfo makeInfo(int64_t columns, int64_t rows, PostFormat format) {
    TerrainInfo info;
    info.scheme = {columns, rows};
    info.worldFromLattice = {{1000, 2000}, {10, 0}, {0, -10}};
    info.format = format;
    return info;
}

std::vector<float> hills(int width, int height, float base, bool holes) {
    std::minstd_rand random(7);
    std::vector<float> posts;
    for (int j = 0; j < height; ++j) {
        for (int i = 0; i < width; ++i) {
            const float noise = static_cast<float>(random() % 1000) / 300.0f;
            const bool hole = holes && (random() % 50 == 0 || (i > 300 && i < 900 && j < 400));
            posts.push_back(hole ? kNaN : base + 80 * std::sin(static_cast<float>(i) / 40) + noise);
        }
    }
    return posts;
}

std::vector<float> throughFile(const TerrainInfo& info, const HeightCodec& codec, ShardId shard,
                               const std::vector<float>& posts) {
    const BlockGrid grid(info.scheme, shard.mip);
    const int width = grid.widthOf(shard.x0, grid.blocksOf(shard));
    auto encoded = encodeShard(info, codec, shard, posts.data(), width);
    EXPECT_TRUE(encoded.ok()) << (encoded.ok() ? "" : encoded.error().message);
    auto file = ShardFile::open(*encoded, info, shard);
    EXPECT_TRUE(file.ok()) << (file.ok() ? "" : file.error().message);
    std::vector<float> out(posts.size()), block(size_t{kBlockPosts} * kBlockPosts);
    for (int x = 0; x < grid.blocksOf(shard); ++x) {
        const auto read = (*file)->read(shard.x0 + x, block.data());
        EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
        for (int j = 0; j < grid.heightOf(shard.y); ++j) {
            for (int i = 0; i < grid.widthOf(shard.x0 + x); ++i) {
                out[static_cast<size_t>(j * width + x * kBlockPosts + i)] =
                    block[static_cast<size_t>(j * kBlockPosts + i)];
            }
        }
    }
    return out;
}

void expectWithin(const std::vector<float>& a, const std::vector<float>& b, double bound) {
    ASSERT_EQ(a.size(), b.size());
    double worst = 0;
    for (size_t k = 0; k < a.size(); ++k) {
        ASSERT_EQ(std::isnan(a[k]), std::isnan(b[k])) << k;
        if (std::isnan(a[k])) continue;
        worst = std::max(worst, std::abs(static_cast<double>(a[k]) - static_cast<double>(b[k])));
    }
    EXPECT_LE(worst, bound);
    if (bound > 0) {
        EXPECT_GT(worst, 0.3 * bound);
    }
}

TEST(ShardCodec, FloatsWithinTheBoundAndHolesKept) {
    const TerrainInfo info = makeInfo(1200, 530, PostFormat::Float32);
    for (const double bound : {0.01, 0.05, 0.25, 2.0}) {
        for (const float base : {0.0f, 300.0f, 8000.0f}) {
            for (const bool holes : {false, true}) {
                const auto posts = hills(1200, 512, base, holes);
                const HeightCodec codec{PostFormat::Float32, 0, 0, bound};
                expectWithin(posts, throughFile(info, codec, {0, 0, 0}, posts), bound);
            }
        }
    }
}

TEST(ShardCodec, LosslessFloatsToTheBit) {
    const TerrainInfo info = makeInfo(600, 600, PostFormat::Float32);
    auto posts = hills(600, 88, 100, true);
    posts[5] = -0.0f;
    posts[6] = 1e30f;
    const auto out = throughFile(info, {PostFormat::Float32, 0, 0, 0}, {0, 0, 1}, posts);
    for (size_t k = 0; k < posts.size(); ++k) {
        if (std::isnan(posts[k])) {
            EXPECT_TRUE(std::isnan(out[k]));
        } else {
            EXPECT_EQ(std::memcmp(&posts[k], &out[k], sizeof(float)), 0) << k;
        }
    }
}

TEST(ShardCodec, BoundBelowFloatPrecisionIsLossless) {
    const TerrainInfo info = makeInfo(600, 100, PostFormat::Float32);
    const auto posts = hills(600, 100, 9000, false);
    expectWithin(posts, throughFile(info, {PostFormat::Float32, 0, 0, 1e-4}, {0, 0, 0}, posts), 0);
}

TEST(ShardCodec, AllHolesAndOneColumn) {
    const TerrainInfo info = makeInfo(4097, 600, PostFormat::Float32);
    std::vector<float> holes(size_t{4096} * 512, kNaN);
    for (const float z : throughFile(info, {PostFormat::Float32, 0, 0, 0.01}, {0, 0, 0}, holes)) {
        ASSERT_TRUE(std::isnan(z));
    }
    const auto posts = hills(1, 512, 0, false);
    expectWithin(posts, throughFile(info, {PostFormat::Float32, 0, 0, 0.01}, {0, 8, 0}, posts),
                 0.01);
}

TEST(ShardCodec, CodesToTheBitAndSameBytesAgain) {
    const TerrainInfo info = makeInfo(700, 513, PostFormat::Int16);
    std::minstd_rand random(3);
    std::vector<uint16_t> codes(size_t{700} * 512);
    for (uint16_t& code : codes) code = static_cast<uint16_t>(random() % 65536);
    const HeightCodec codec{PostFormat::Int16, -100, 0.125f, 0};
    auto encoded = encodeShard(info, codec, {0, 0, 0}, codes.data(), 700);
    auto again = encodeShard(info, codec, {0, 0, 0}, codes.data(), 700);
    ASSERT_TRUE(encoded.ok() && again.ok());
    EXPECT_EQ(encoded->bytes, again->bytes);
    ASSERT_EQ(encoded->blocks.size(), 2u);
    EXPECT_GT(encoded->blocks[1].size, 1000u);
    auto file = ShardFile::open(*encoded, info, {0, 0, 0});
    ASSERT_TRUE(file.ok());
    std::vector<uint16_t> block(size_t{kBlockPosts} * kBlockPosts);
    ASSERT_TRUE((*file)->read(1, block.data()).ok());
    for (int j = 0; j < 512; ++j) {
        for (int i = 0; i < 188; ++i) {
            ASSERT_EQ(block[static_cast<size_t>(j * 512 + i)],
                      codes[static_cast<size_t>(j * 700 + 512 + i)]);
        }
    }
}

TEST(ShardCodec, RoundedCodesStayWithinTheBound) {
    for (const double bound : {0.0, 0.05, 0.13, 1.0, 40.0}) {
        const HeightCodec codec{PostFormat::Int16, 0, 0.125f, bound};
        const int step = codec.codeStep();
        for (int k = 0; k <= 65535; ++k) {
            uint16_t code = static_cast<uint16_t>(k);
            roundCodes(&code, 1, step);
            if (k == kHolePost) {
                ASSERT_EQ(code, kHolePost);
            } else {
                ASSERT_NE(code, kHolePost);
                ASSERT_LE(0.125 * std::abs(code - k), bound) << k;
            }
        }
        if (bound >= 0.13) {
            EXPECT_GT(step, 1);
        }
    }
}

TEST(ShardCodec, OtherFilesAreRefused) {
    const TerrainInfo info = makeInfo(600, 100, PostFormat::Float32);
    const auto posts = hills(600, 100, 0, false);
    auto encoded =
        encodeShard(info, {PostFormat::Float32, 0, 0, 0.01}, {0, 0, 0}, posts.data(), 600);
    ASSERT_TRUE(encoded.ok());
    EXPECT_FALSE(
        ShardFile::open(*encoded, makeInfo(601, 100, PostFormat::Float32), {0, 0, 0}).ok());
    EXPECT_FALSE(ShardFile::open(*encoded, makeInfo(600, 100, PostFormat::Int16), {0, 0, 0}).ok());
    encoded->bytes.resize(100);
    EXPECT_FALSE(ShardFile::open(*encoded, info, {0, 0, 0}).ok());
}

}  // namespace
}  // namespace terray
