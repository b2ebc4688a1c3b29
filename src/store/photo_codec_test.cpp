// SPDX-License-Identifier: Apache-2.0
// Photo files come back as they went in, or close to it; nothing rings in from what is not covered.
#include "store/photo_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "store/vrt.h"

namespace terray {
namespace {

TerrainInfo makeInfo() {
    TerrainInfo info;
    info.scheme = {100, 100};
    info.worldFromLattice = {{1000, 2000}, {10, 0}, {0, -10}};
    return info;
}

PhotoLayer makeLayer(int quality) {
    return {1100, 600, {{1000, 2000}, {1, 0}, {0, -1}}, quality, ""};
}

/// Soft colours; uncovered (and black) in a disk.
std::vector<uint8_t> picture(int width, int height, bool hasHole) {
    std::vector<uint8_t> rgba;
    for (int j = 0; j < height; ++j) {
        for (int i = 0; i < width; ++i) {
            const bool hole = hasHole && (i - 500) * (i - 500) + (j - 40) * (j - 40) < 60 * 60;
            const auto wave = [&](double phase) {
                return static_cast<uint8_t>(150 + 90 * std::sin(i / 60.0 + j / 90.0 + phase));
            };
            const uint8_t pixel[4] = {wave(0), wave(1), wave(2), 255};
            for (const uint8_t value : pixel) rgba.push_back(hole ? uint8_t{0} : value);
        }
    }
    return rgba;
}

/// Through a file on disk, and back.
std::vector<uint8_t> throughFile(const PhotoLayer& layer, ShardId shard,
                                 const std::vector<uint8_t>& rgba) {
    const BlockGrid grid = layer.grid(shard.mip);
    const int width = grid.widthOf(shard.x0, grid.blocksOf(shard));
    const auto encoded =
        encodePhotoShard(makeInfo(), layer, shard, rgba.data(), int64_t{width} * 4);
    EXPECT_TRUE(encoded.ok()) << (encoded.ok() ? "" : encoded.error().message);
    const auto again = encodePhotoShard(makeInfo(), layer, shard, rgba.data(), int64_t{width} * 4);
    EXPECT_TRUE(encoded->bytes == again->bytes);
    for (const BlockRange& range : encoded->blocks) {
        EXPECT_GT(range.size, 0u);
        EXPECT_LE(range.offset + range.size, encoded->bytes.size());
    }
    const std::string path = testing::TempDir() + "photo_codec_test.tif";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(encoded->bytes.data()),
               static_cast<std::streamsize>(encoded->bytes.size()));
    auto file = PhotoShardFile::open(path, layer, shard);
    EXPECT_TRUE(file.ok()) << (file.ok() ? "" : file.error().message);
    std::vector<uint8_t> out(rgba.size()), block(kPhotoBlockBytes);
    for (int x = shard.x0; x < shard.x0 + grid.blocksOf(shard); ++x) {
        const auto read = (*file)->read(x, block.data());
        EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
        for (int j = 0; j < grid.heightOf(shard.y); ++j) {
            std::copy_n(block.data() + j * kBlockPosts * 4, grid.widthOf(x) * 4,
                        out.data() + (j * width + (x - shard.x0) * kBlockPosts) * 4);
        }
        if (grid.widthOf(x) < kBlockPosts) {
            EXPECT_EQ(block[static_cast<size_t>(grid.widthOf(x)) * 4 + 3], 0);
        }
    }
    return out;
}

TEST(PhotoCodec, LosslessIsExact) {
    std::vector<uint8_t> rgba = picture(1100, 512, true);
    for (size_t k = 0; k < 4000; ++k) rgba[4 * k + 3] = static_cast<uint8_t>(1 + k % 255);
    EXPECT_TRUE(throughFile(makeLayer(0), {0, 0, 0}, rgba) == rgba);
}

TEST(PhotoCodec, JpegIsCloseAndCoversTheSamePixels) {
    for (const bool hasHole : {false, true}) {
        const std::vector<uint8_t> rgba = picture(1100, 512, hasHole);
        const std::vector<uint8_t> out = throughFile(makeLayer(90), {0, 0, 0}, rgba);
        int worst = 0;
        for (size_t k = 0; k < rgba.size(); k += 4) {
            ASSERT_EQ(out[k + 3], rgba[k + 3]) << k / 4;
            for (size_t c = 0; c < 3; ++c)
                worst = std::max(worst, std::abs(out[k + c] - rgba[k + c]));
        }
        EXPECT_LE(worst, hasHole ? 14 : 8);
        EXPECT_GT(worst, 0);
    }
}

TEST(PhotoCodec, OtherFilesThanTheManifestSaysAreRefused) {
    throughFile(makeLayer(90), {0, 0, 0}, picture(1100, 512, false));
    const std::string path = testing::TempDir() + "photo_codec_test.tif";
    EXPECT_FALSE(PhotoShardFile::open(path, makeLayer(0), {0, 0, 0}).ok());
    EXPECT_FALSE(PhotoShardFile::open(path, makeLayer(90), {0, 0, 1}).ok());
    EXPECT_FALSE(PhotoShardFile::open(path + ".missing", makeLayer(90), {0, 0, 0}).ok());
}

TEST(PhotoLayer, MipsHalveRoundedUpAndKeepTheirCorner) {
    const PhotoLayer layer = makeLayer(90);
    ASSERT_EQ(layer.mipCount(), 3);
    EXPECT_EQ(layer.grid(2).columns, 275);
    EXPECT_EQ(layer.grid(2).rows, 150);
    EXPECT_EQ(PhotoLayer({513, 1, {}, 0, ""}).grid(1).columns, 257);
    const GeoTransform fine = layer.geoTransform(1, 0, 0, 0),
                       coarse = layer.geoTransform(1, 2, 0, 0);
    EXPECT_EQ(fine.values[0], 999.5);
    EXPECT_EQ(coarse.values[0], 999.5);
    EXPECT_EQ(coarse.values[3], 2000.5);
    EXPECT_EQ(coarse.values[1], 4);
    EXPECT_EQ(layer.geoTransform(2, 1, 10, 0).values[0], (999.5 + 20) / 2);
}

}  // namespace
}  // namespace terray
