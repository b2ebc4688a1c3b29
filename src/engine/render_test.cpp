// SPDX-License-Identifier: Apache-2.0
// Pictures of a synthetic terrain: the same from bands, threads and memory; files whole or none.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/interrupt.h"
#include "engine/bands.h"
#include "engine/sample_pattern.h"
#include "terray/renderer.h"
#include "terray/terrain.h"

namespace terray {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTerrain = "synthetic:fractal?size=300&cell=10&seed=3";

View smallView() {
    View view;
    view.width = 200;
    view.height = 150;
    return view;
}

/// An empty folder of this test, removed at its end.
class RenderTest : public testing::Test {
protected:
    RenderTest()
        : folder_(fs::temp_directory_path() /
                  (std::string("terray_render_") +
                   testing::UnitTest::GetInstance()->current_test_info()->name())) {
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    ~RenderTest() override { fs::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    size_t filesLeft() const {
        return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), {}));
    }

    fs::path folder_;
};

std::string bytesOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<uint8_t> pictureOf(const Terrain& terrain, const View& view,
                               const RenderOptions& options = {}) {
    std::vector<uint8_t> rgba(static_cast<size_t>(view.width) * static_cast<size_t>(view.height) *
                              4);
    const auto stats = render(terrain, view, options, rgba);
    EXPECT_TRUE(stats.ok()) << stats.error().message;
    return rgba;
}

TEST_F(RenderTest, ThreadsDoNotChangeAPixel) {
    OpenOptions one;
    one.threads = 1;
    const auto single = Terrain::open(kTerrain, one);
    const auto all = Terrain::open(kTerrain);
    ASSERT_TRUE(single.ok() && all.ok());
    EXPECT_EQ(pictureOf(*single, smallView()), pictureOf(*all, smallView()));
}

TEST_F(RenderTest, EverySampleCountSeesTheSameTerrain) {
    const auto terrain = Terrain::open(kTerrain);
    ASSERT_TRUE(terrain.ok());
    RenderOptions options;
    options.samples = 16;
    const auto reference = pictureOf(*terrain, smallView(), options);
    for (const int samples : {1, 2, 4, 8}) {
        options.samples = samples;
        const auto picture = pictureOf(*terrain, smallView(), options);
        double sum = 0;
        for (size_t k = 0; k < picture.size(); ++k)
            sum += std::abs(static_cast<double>(picture[k]) - static_cast<double>(reference[k]));
        EXPECT_LT(sum / static_cast<double>(picture.size()), 8.0) << samples;
    }
}

TEST_F(RenderTest, SamplePatternsAreCentredAndDistinct) {
    for (const int samples : {1, 2, 4, 8, 16}) {
        const auto pattern = samplePattern(samples);
        ASSERT_EQ(pattern.size(), static_cast<size_t>(samples));
        Vec2 mean{0, 0};
        for (const Vec2 p : pattern) {
            EXPECT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
            mean += p / static_cast<double>(samples);
        }
        EXPECT_NEAR(mean.x, 0.5, 0.04);
        EXPECT_NEAR(mean.y, 0.5, 0.04);
        for (size_t a = 0; a < pattern.size(); ++a)
            for (size_t b = 0; b < a; ++b) EXPECT_NE(pattern[a].x, pattern[b].x);
    }
}

TEST_F(RenderTest, BandsShrinkWithTheWidthOfThePicture) {
    BandDemand demand;
    demand.linear = true;
    demand.aovs = {Aov::Position, Aov::Distance};
    for (const int width : {1, 100, 1920, 40'000, 1'000'000}) {
        const int rows = bandRows(width, demand);
        EXPECT_GE(rows, 1);
        EXPECT_LE(rows, 256);
        EXPECT_LE(static_cast<size_t>(rows) * static_cast<size_t>(width) * 36, size_t{36} << 20);
    }
    EXPECT_EQ(bandRows(1920, BandDemand{}), 256);
}

TEST_F(RenderTest, FilesHoldWhatMemoryHolds) {
    const auto terrain = Terrain::open(kTerrain);
    ASSERT_TRUE(terrain.ok());
    View view = smallView();
    view.height = 700;  // several bands
    OutputOptions outputs;
    outputs.path = path("a.png");
    const auto first = renderToFiles(*terrain, view, {}, outputs);
    ASSERT_TRUE(first.ok()) << first.error().message;
    outputs.path = path("b.png");
    outputs.aovs = {{Aov::Distance, path("d.tif")}, {Aov::Normal, path("n.exr")}};
    const auto second = renderToFiles(*terrain, view, {}, outputs);
    ASSERT_TRUE(second.ok()) << second.error().message;
    EXPECT_EQ(bytesOf(path("a.png")), bytesOf(path("b.png")));
    EXPECT_EQ(filesLeft(), 4u);
    EXPECT_EQ(first->rays, 200u * 700u * 4u);
    EXPECT_EQ(second->rays, 200u * 700u * 5u);
    EXPECT_GT(first->hits, 1000u);
}

TEST_F(RenderTest, FailureOfOneOutputLeavesNoneBehind) {
    const auto terrain = Terrain::open(kTerrain);
    ASSERT_TRUE(terrain.ok());
    OutputOptions outputs;
    outputs.path = path("a.png");
    outputs.aovs = {{Aov::Distance, path("missing/d.tif")}};
    const auto stats = renderToFiles(*terrain, smallView(), {}, outputs);
    ASSERT_FALSE(stats.ok());
    EXPECT_EQ(stats.error().code, ErrorCode::Failed);
    EXPECT_EQ(filesLeft(), 0u);
    EXPECT_FALSE(checkRender(smallView(), {}, outputs).ok());
    EXPECT_EQ(filesLeft(), 0u);
}

TEST_F(RenderTest, AnInterruptLeavesNothingBehind) {
    const auto terrain = Terrain::open(kTerrain);
    ASSERT_TRUE(terrain.ok());
    OutputOptions outputs;
    outputs.path = path("a.png");
    setInterrupted(true);
    const auto stats = renderToFiles(*terrain, smallView(), {}, outputs);
    setInterrupted(false);
    ASSERT_FALSE(stats.ok());
    EXPECT_EQ(stats.error().code, ErrorCode::Interrupted);
    EXPECT_EQ(filesLeft(), 0u);
}

TEST_F(RenderTest, TheSourceIsNotOverwritten) {
    std::ofstream(path("dem.asc")) << "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\n"
                                      "1 2 3\n4 5 6\n7 8 9\n";
    const auto terrain = Terrain::open(path("dem.asc"));
    ASSERT_TRUE(terrain.ok()) << terrain.error().message;
    fs::create_symlink("dem.asc", folder_ / "link.png");
    OutputOptions outputs;
    outputs.path = path("link.png");
    const auto stats = renderToFiles(*terrain, smallView(), {}, outputs);
    ASSERT_FALSE(stats.ok());
    EXPECT_EQ(stats.error().code, ErrorCode::Usage);
}

TEST_F(RenderTest, AWrongBufferSizeIsUsage) {
    const auto terrain = Terrain::open(kTerrain);
    ASSERT_TRUE(terrain.ok());
    std::vector<uint8_t> rgba(10);
    const auto stats = render(*terrain, smallView(), {}, rgba);
    ASSERT_FALSE(stats.ok());
    EXPECT_EQ(stats.error().code, ErrorCode::Usage);
}

}  // namespace
}  // namespace terray
