// SPDX-License-Identifier: Apache-2.0
// A store's photo by blocks: the picture of the whole one, whatever the budget; late blocks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "raster/test_photo_files.h"
#include "terray/bake.h"
#include "terray/process.h"
#include "terray/renderer.h"

namespace terray {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMebibyte = uint64_t{1} << 20;

class StorePhotoTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        setQuiet(true);
        TestRaster dem;
        dem.width = 200, dem.height = 170, dem.bands = 1;
        dem.type = GDT_Float32;
        dem.crs = "EPSG:32633";
        dem.transform = {500000, 20, 0, 5200000, 0, -20};
        dem.value = [](int, int i, int j) {
            return 500 + 60 * std::sin(i * 0.11) * std::cos(j * 0.13);
        };
        dem_ = writeRaster("store_photo_dem.tif", dem);
        TestRaster photo;
        photo.width = 2700, photo.height = 2100;
        photo.crs = dem.crs;
        photo.transform = {500010, 1.45, 0, 5199990, 0, -1.45};
        photo.value = [](int band, int i, int j) {
            return static_cast<double>((i * (band + 2) / 3 + j * 2 + (i ^ j) % 31 * band) & 255);
        };
        photo_ = writeRaster("store_photo.tif", photo);
        store_ = testing::TempDir() + "store_photo.terray";
        fs::remove_all(store_);
        BakeOptions options;
        options.open.photo = photo_;
        options.maxError = 0;
        options.photoQuality = 0;
        const auto baked = bake(std::span(&dem_, 1), store_, options);
        ASSERT_TRUE(baked.ok()) << baked.error().message;
    }
    static void TearDownTestSuite() {
        fs::remove_all(store_);
        fs::remove(dem_);
        fs::remove(photo_);
    }

    static Result<Terrain> open(uint64_t mebibytes) {
        OpenOptions options;
        options.memoryBytes = mebibytes * kMebibyte;
        return Terrain::open(store_, options);
    }
    static View lowView() {
        View view;
        view.width = 480;
        view.height = 270;
        view.eye = Place{500300, 5196900, 150, true};
        view.headingDeg = 45;
        view.pitchDeg = -12;
        return view;
    }
    static RenderOptions plain() {
        RenderOptions options;
        options.samples = 2;
        return options;
    }
    struct Picture {
        std::vector<uint8_t> rgba;
        RenderStats stats;
    };
    static Picture pictureOf(const Terrain& terrain, const View& view,
                             const RenderOptions& options) {
        Picture picture;
        picture.rgba.resize(static_cast<size_t>(view.width) * static_cast<size_t>(view.height) * 4);
        auto stats = render(terrain, view, options, picture.rgba);
        EXPECT_TRUE(stats.ok()) << stats.error().message;
        if (stats) picture.stats = *stats;
        return picture;
    }

    static inline std::string dem_, photo_, store_;
};

TEST_F(StorePhotoTest, AnyBudgetGivesThePictureOfTheWholePhoto) {
    OpenOptions draped;
    draped.photo = photo_;
    const auto direct = Terrain::open(dem_, draped);
    ASSERT_TRUE(direct.ok()) << direct.error().message;
    const auto large = open(1024), small = open(32);
    ASSERT_TRUE(large.ok() && small.ok());
    uint64_t evicted = 0, wanted = 0;
    for (int k = 0; k < 7; ++k) {
        View view = lowView();
        view.eye->x += 900 * (k % 4);
        view.headingDeg = 45 + 60 * k;
        const Picture expected = pictureOf(*direct, view, plain());
        const Picture whole = pictureOf(*large, view, plain());
        const Picture byBlocks = pictureOf(*small, view, plain());
        EXPECT_EQ(whole.rgba, expected.rgba);
        EXPECT_EQ(byBlocks.rgba, expected.rgba);
        EXPECT_EQ(whole.stats.photoBlocksEvicted, 0u);
        EXPECT_EQ(byBlocks.stats.photoMissingPixels, 0u);
        EXPECT_EQ(byBlocks.stats.photoBlocksAbsent, 0u);
        EXPECT_EQ(byBlocks.stats.rays, expected.stats.rays);
        EXPECT_EQ(byBlocks.stats.hits, expected.stats.hits);
        evicted += byBlocks.stats.photoBlocksEvicted;
        wanted += byBlocks.stats.photoBlocksWanted;
    }
    EXPECT_GT(evicted, 0u) << wanted;
}

TEST_F(StorePhotoTest, APictureMayWantMoreBlocksThanThereIsRoomFor) {
    OpenOptions draped;
    draped.photo = photo_;
    const auto direct = Terrain::open(dem_, draped);
    const auto small = open(32);
    ASSERT_TRUE(direct.ok() && small.ok());
    View map;
    map.projection = Projection::Ortho;
    map.width = 1800;
    map.height = 800;
    map.extent = Extent{500000, 5197300, 504000, 5199078};
    RenderOptions options;
    options.samples = 1;
    const Picture byBlocks = pictureOf(*small, map, options);
    EXPECT_GT(byBlocks.stats.photoBlocksWanted, 24u);
    EXPECT_GT(byBlocks.stats.photoBlocksEvicted, 0u);
    EXPECT_EQ(byBlocks.stats.photoMissingPixels, 0u);
    EXPECT_EQ(byBlocks.stats.rays, 1800u * 800u);
    EXPECT_EQ(byBlocks.rgba, pictureOf(*direct, map, options).rgba);
}

TEST_F(StorePhotoTest, LateBlocksAreStoodInForAndCounted) {
    const auto terrain = open(1024);
    ASSERT_TRUE(terrain.ok());
    RenderOptions live = plain();
    live.waitForTiles = false;
    const Picture first = pictureOf(*terrain, lowView(), live);
    EXPECT_GT(first.stats.photoMissingPixels, 0u);
    EXPECT_GT(first.stats.photoBlocksAbsent, 0u);
    Picture last = first;
    for (int k = 0; k < 500 && last.stats.photoMissingPixels > 0; ++k)
        last = pictureOf(*terrain, lowView(), live);
    EXPECT_EQ(last.stats.photoMissingPixels, 0u);
    EXPECT_EQ(last.rgba, pictureOf(*terrain, lowView(), plain()).rgba);
    EXPECT_NE(first.rgba, last.rgba);
}

}  // namespace
}  // namespace terray
