// SPDX-License-Identifier: Apache-2.0
// A store's photo is the source's, its mips are means of light; whatever threads, memory, stops.
#include <tbb/task_arena.h>

#include <cmath>
#include <fstream>

#include "bake/test_folder.h"
#include "store/photo_reader.h"
#include "store/verify.h"
#include "tile/photo_mips.h"

namespace terray {
namespace {

using test::ArraySource;
using test::bakeWell;
using test::FailingCalls;
using test::filesOf;
using test::TestFolder;

/// Soft colours with a corner that is not covered.
class WavePhoto final : public PhotoSource {
public:
    WavePhoto(int64_t columns, int64_t rows) : columns_(columns), rows_(rows) {}
    int64_t columns() const override { return columns_; }
    int64_t rows() const override { return rows_; }
    const Affine2& worldFromPixel() const override { return map_; }
    const std::string& description() const override { return description_; }
    int64_t preferredRows() const override { return 100; }
    Result<std::unique_ptr<PhotoReader>> makeReader() const override {
        return std::unique_ptr<PhotoReader>(new Reader);
    }
    static void pixel(int64_t i, int64_t j, uint8_t* out) {
        for (int c = 0; c < 3; ++c) {
            out[c] = static_cast<uint8_t>(
                128 + 100 * std::sin(static_cast<double>(i + c * j) / (20 + 9 * c)));
        }
        out[3] = i + j < 300 ? 0 : 255;
        if (out[3] == 0) std::fill_n(out, 3, uint8_t{0});
    }

private:
    class Reader final : public PhotoReader {
        Result<void> read(int64_t column, int64_t row, int64_t width, int64_t height, uint8_t* rgba,
                          ptrdiff_t stride) override {
            for (int64_t j = 0; j < height; ++j) {
                for (int64_t i = 0; i < width; ++i) {
                    pixel(column + i, row + j, rgba + j * stride + i * 4);
                }
            }
            return {};
        }
    };
    int64_t columns_, rows_;
    Affine2 map_{{1000, 2000}, {0.5, 0}, {0, -0.5}};
    std::string description_ = "waves";
};

const ArraySource& smallDem() {
    static const ArraySource source(60, 50, PostFormat::Float32, test::hills(4, false));
    return source;
}

BakePlan planWith(const PhotoSource& photo, int quality) {
    BakePlan plan = test::planOf(smallDem(), 0.05);
    plan.photo = &photo;
    plan.manifest.photo = PhotoLayer{photo.columns(), photo.rows(), photo.worldFromPixel(), quality,
                                     photo.description()};
    return plan;
}

/// All pixels of a mip.
std::vector<uint8_t> mipOf(const Store& store, int mip) {
    const PhotoLayer& layer = *store.manifest().photo;
    const BlockGrid grid = layer.grid(mip);
    std::vector<uint8_t> all(static_cast<size_t>(grid.columns * grid.rows * 4));
    std::vector<uint8_t> block(kPhotoBlockBytes);
    StorePhotoReader reader(store.path(), layer);
    for (int y = 0; y < grid.blocksY; ++y) {
        for (int x = 0; x < grid.blocksX; ++x) {
            const auto read = reader.read(mip, x, y, block.data());
            EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
            for (int row = 0; row < grid.heightOf(y); ++row) {
                std::copy_n(block.data() + row * kBlockPosts * 4, grid.widthOf(x) * 4,
                            all.data() + ((int64_t{y} * kBlockPosts + row) * grid.columns +
                                          int64_t{x} * kBlockPosts) *
                                             4);
            }
        }
    }
    return all;
}

TEST(PhotoBake, LosslessMipsAreTheSourceAndItsMeans) {
    const WavePhoto photo(4700, 530);
    const TestFolder folder;
    bakeWell(planWith(photo, 0), folder / "a.terray");
    const auto store = Store::open(folder / "a.terray", uint64_t{1} << 30);
    ASSERT_TRUE(store.ok()) << store.error().message;
    const PhotoLayer& layer = *(*store)->manifest().photo;
    EXPECT_EQ(layer.description, "waves");
    ASSERT_EQ(layer.mipCount(), 5);
    std::vector<uint8_t> fine = mipOf(**store, 0);
    for (int64_t k = 0; k < 4700 * 530; ++k) {
        uint8_t expected[4];
        WavePhoto::pixel(k % 4700, k / 4700, expected);
        ASSERT_TRUE(std::equal(expected, expected + 4, fine.data() + 4 * k)) << k;
    }
    for (int mip = 1; mip < 5; ++mip) {
        const std::vector<uint8_t> coarse = mipOf(**store, mip);
        const BlockGrid grid = layer.grid(mip), finer = layer.grid(mip - 1);
        std::vector<uint8_t> block(kPhotoBlockBytes);
        uint8_t expected[4];
        for (int64_t k = 0; k < grid.columns * grid.rows; k += 37) {
            const int64_t x = 2 * (k % grid.columns), y = 2 * (k / grid.columns);
            const int width = x + 1 < finer.columns ? 2 : 1, height = y + 1 < finer.rows ? 2 : 1;
            for (int row = 0; row < height; ++row) {
                std::copy_n(fine.data() + ((y + row) * finer.columns + x) * 4, width * 4,
                            block.data() + row * kBlockPosts * 4);
            }
            halvePhoto(block.data(), width, height, kBlockPosts * 4, expected, 4);
            ASSERT_TRUE(std::equal(expected, expected + 4, coarse.data() + 4 * k))
                << "mip " << mip << " pixel " << k;
        }
        fine = coarse;
    }
}

TEST(PhotoBake, MeansAreOfLightAndOfWhatIsCovered) {
    std::vector<uint8_t> block(kPhotoBlockBytes);
    const uint8_t row[] = {0, 0, 0, 255, 255, 255, 255, 255, 9, 90, 200, 255};
    std::copy_n(row, 12, block.data());
    uint8_t out[8];
    halvePhoto(block.data(), 3, 2, kBlockPosts * 4, out, 8);
    EXPECT_EQ(out[0], 188);  // half the light of white; the row below is not covered
    EXPECT_EQ(out[3], 128);
    EXPECT_EQ(out[4], 9);
    EXPECT_EQ(out[5], 90);
    EXPECT_EQ(out[6], 200);
    EXPECT_EQ(out[7], 128);
}

TEST(PhotoBake, SameBytesOnAnyNumberOfThreadsAndAnyMemory) {
    const WavePhoto photo(4700, 1100);
    const TestFolder folder;
    BakePlan plan = planWith(photo, 80);
    tbb::task_arena one(1), four(4);
    one.execute([&] { bakeWell(plan, folder / "one.terray"); });
    plan.memoryBytes = 1 << 20;
    four.execute([&] { bakeWell(plan, folder / "four.terray"); });
    const auto a = filesOf(folder / "one.terray"), b = filesOf(folder / "four.terray");
    EXPECT_EQ(a.count("photo/m4/y0_x0.tif"), 1u);
    EXPECT_TRUE(a == b);
    EXPECT_TRUE(checkStore(folder / "one.terray")->damage.empty());
}

TEST(PhotoBake, StoppedAnywhereItGoesOnAndNothingIsMadeTwice) {
    const WavePhoto photo(1500, 600);
    const TestFolder folder;
    BakePlan plan = planWith(photo, 90);
    bakeWell(plan, folder / "good.terray");
    FailingCalls calls;
    plan.calls = &calls;
    int failures = 0;
    for (int allowed = 1; allowed < 1000; allowed += 3) {
        calls.writes = 0;
        calls.failFrom = allowed / 2 + 2;
        if (bakeStore(plan, folder / "a.terray", false).ok()) break;
        ++failures;
    }
    EXPECT_GT(failures, 3);
    EXPECT_TRUE(filesOf(folder / "a.terray") == filesOf(folder / "good.terray"));
    EXPECT_LE(calls.renamed.at("m0/y0_x0.tif"), 3 * 2);  // a height file has that name, too
}

TEST(PhotoBake, DamageIsNamedAndMended) {
    const WavePhoto photo(1500, 600);
    const TestFolder folder;
    const std::string out = folder / "a.terray", file = out + "/photo/m0/y0_x0.tif";
    const BakePlan plan = planWith(photo, 90);
    bakeWell(plan, out);
    const auto good = filesOf(out);
    const auto size = static_cast<std::streamoff>(std::filesystem::file_size(file));
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(size / 2).put('\x5a');
    const auto check = checkStore(out);
    ASSERT_EQ(check->damage.size(), 1u);
    EXPECT_NE(check->damage[0].find("of mip 0 of the photo is damaged"), std::string::npos)
        << check->damage[0];
    bakeWell(plan, out, true);
    EXPECT_TRUE(filesOf(out) == good);
    std::filesystem::remove(file);
    const auto opened = Store::open(out, uint64_t{1} << 30);
    ASSERT_TRUE(opened.ok());
    StorePhotoReader reader(out, *(*opened)->manifest().photo);
    std::vector<uint8_t> block(kPhotoBlockBytes);
    const auto read = reader.read(0, 1, 0, block.data());
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().message.find("block (1, 0) of mip 0 of the photo"), std::string::npos);
    EXPECT_NE(read.error().message.find("terray verify"), std::string::npos);
}

}  // namespace
}  // namespace terray
