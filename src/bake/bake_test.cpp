// SPDX-License-Identifier: Apache-2.0
// What a store holds is what its source says: posts, bounds, errors; whatever threads and memory.
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>

#include "bake/test_folder.h"
#include "stream/pool.h"

namespace terray {
namespace {

using test::ArraySource;
using test::bakeWell;
using test::filesOf;
using test::hills;
using test::planOf;
using test::TestFolder;

std::unique_ptr<Store> opened(const std::string& path) {
    auto store = Store::open(path, uint64_t{1} << 30);
    EXPECT_TRUE(store.ok()) << (store.ok() ? "" : store.error().message);
    return store.ok() ? std::move(*store) : nullptr;
}

void expectSameTerrain(const ResidentTerrain& a, const ResidentTerrain& b) {
    ASSERT_EQ(a.mipCount(), b.mipCount());
    EXPECT_EQ(a.info().minZ, b.info().minZ);
    EXPECT_EQ(a.info().maxZ, b.info().maxZ);
    for (uint32_t slot = 0; slot < a.pool().tiles.size(); ++slot) {
        const TileId id = a.pool().ids[slot];
        const int width = a.pool().cellsX(id) + 1;
        std::vector<float> rowA(static_cast<size_t>(width)), rowB(rowA);
        for (int row = 0; row <= a.pool().cellsY(id); ++row) {
            a.pool().decodeRow(slot, row, 0, width, rowA.data());
            b.pool().decodeRow(slot, row, 0, width, rowB.data());
            for (int k = 0; k < width; ++k) {
                const float x = rowA[static_cast<size_t>(k)], y = rowB[static_cast<size_t>(k)];
                ASSERT_TRUE(x == y || (std::isnan(x) && std::isnan(y)))
                    << "mip " << id.mip << " tile " << id.x << "," << id.y << " row " << row
                    << " column " << k << ": " << x << " " << y;
            }
        }
        for (size_t k = 0; k < a.blocks(slot).size(); ++k) {
            const BlockBounds &x = a.blocks(slot)[k], &y = b.blocks(slot)[k];
            ASSERT_EQ(std::memcmp(&x, &y, sizeof(x)), 0)
                << "mip " << id.mip << " tile " << id.x << "," << id.y << " block " << k
                << " errors " << x.errorToFinest << " " << y.errorToFinest << ", " << x.errorToNext
                << " " << y.errorToNext;
        }
    }
}

class BakeSizes : public testing::TestWithParam<std::tuple<int, int, PostFormat>> {};

TEST_P(BakeSizes, LosslessStoreIsTheResidentTerrain) {
    const auto [columns, rows, format] = GetParam();
    const ArraySource source(columns, rows, format, hills(5, true));
    const TestFolder folder;
    bakeWell(planOf(source, 0), folder / "a.terray");
    const auto store = opened(folder / "a.terray");
    ASSERT_NE(store, nullptr);
    const auto raw = test::built(source);
    BuildStats stats, rawStats;
    auto baked = ResidentTerrain::build(*store, uint64_t{4} << 30, stats);
    ASSERT_TRUE(baked.ok()) << baked.error().message;
    expectSameTerrain(*raw, **baked);
    ASSERT_TRUE(ResidentTerrain::build(source, uint64_t{4} << 30, rawStats).ok());
    EXPECT_EQ(stats.holes, rawStats.holes);
    EXPECT_GT(stats.holes, 20u);
}

INSTANTIATE_TEST_SUITE_P(Sizes, BakeSizes,
                         testing::Values(std::tuple(900, 700, PostFormat::Int16),
                                         std::tuple(1025, 513, PostFormat::Float32),
                                         std::tuple(513, 1100, PostFormat::Int16),
                                         std::tuple(2100, 1030, PostFormat::Float32),
                                         std::tuple(4098, 40, PostFormat::Float32)));

TEST(Bake, SmallestTerrain) {
    const ArraySource source(2, 2, PostFormat::Float32,
                             [](int64_t i, int64_t j) { return static_cast<float>(i + 2 * j); });
    const TestFolder folder;
    bakeWell(planOf(source, 0.01), folder / "a.terray");
    const auto store = opened(folder / "a.terray");
    ASSERT_NE(store, nullptr);
    EXPECT_EQ(store->info().scheme.mipCount(), 1);
    EXPECT_NEAR(store->info().maxZ, 3, 0.01);
}

TEST(Bake, InfiniteHeightsAreHoles) {
    for (const double maxError : {0.0, 0.01}) {
        const ArraySource source(40, 30, PostFormat::Float32, [](int64_t i, int64_t j) {
            return i == 5 ? HUGE_VALF : i == 9 ? -HUGE_VALF : static_cast<float>(i + j);
        });
        const TestFolder folder;
        bakeWell(planOf(source, maxError), folder / "a.terray");
        const auto store = opened(folder / "a.terray");
        ASSERT_NE(store, nullptr);
        EXPECT_EQ(store->holes(), 60u);
        EXPECT_NEAR(store->info().maxZ, 68, maxError);
    }
}

TEST(Bake, AllHoles) {
    const ArraySource source(600, 20, PostFormat::Float32,
                             [](int64_t, int64_t) { return test::kNaN; });
    const TestFolder folder;
    bakeWell(planOf(source, 0.01), folder / "a.terray");
    const auto store = opened(folder / "a.terray");
    ASSERT_NE(store, nullptr);
    EXPECT_EQ(store->holes(), 600u * 20u);
    EXPECT_GT(store->bounds(0)[0].minZ, store->bounds(0)[0].maxZ);
}

/// Reads every tile and holds its bounds against its own posts and those of mip 0.
class StrictBounds {
public:
    explicit StrictBounds(const Store& store) : store_(store), scheme_(store.info().scheme) {
        auto reader = store.makeReader();
        EXPECT_TRUE(reader.ok());
        reader_ = std::move(*reader);
        finest_ = readMip(0);
    }
    void check(int mip) {
        const std::vector<float> posts = mip == 0 ? finest_ : readMip(mip);
        const int64_t width = scheme_.columnsAt(mip);
        const int step = 1 << mip;
        for (int64_t j = 0; j < scheme_.rows; ++j) {
            for (int64_t i = 0; i < scheme_.columns; ++i) {
                const float exact = finest_[static_cast<size_t>(j * scheme_.columns + i)];
                const int64_t x = i >> mip, y = j >> mip;
                const double u = static_cast<double>(i - (x << mip)) / step;
                const double v = static_cast<double>(j - (y << mip)) / step;
                const auto at = [&](int64_t a, int64_t b) {
                    a = std::min(a, width - 1);
                    b = std::min(b, scheme_.rowsAt(mip) - 1);
                    return static_cast<double>(posts[static_cast<size_t>(b * width + a)]);
                };
                const double surface = (1 - v) * mix(at(x, y), at(x + 1, y), u) +
                                       v * mix(at(x, y + 1), at(x + 1, y + 1), u);
                if (std::isnan(exact) || std::isnan(surface)) continue;
                const BlockBounds& block = blockOf(mip, x, y);
                ASSERT_LE(std::abs(surface - static_cast<double>(exact)), block.errorToFinest)
                    << "mip " << mip << " at " << i << "," << j;
                if (u > 0 || v > 0) continue;
                ++posts_;
                if (block.minZ > block.maxZ) continue;
                ASSERT_GE(surface, block.minZ);
                ASSERT_LE(surface, block.maxZ);
            }
        }
    }
    int64_t posts() const { return posts_; }
    const std::vector<float>& finest() const { return finest_; }

private:
    static double mix(double a, double b, double t) { return t == 0 ? a : a + t * (b - a); }
    const BlockBounds& blockOf(int mip, int64_t x, int64_t y) const {
        const int64_t width = int64_t{scheme_.tilesX(mip)} * kTileBlocks;
        const int64_t bx = std::min(x, scheme_.columnsAt(mip) - 2) / kBlockCells;
        const int64_t by = std::min(y, scheme_.rowsAt(mip) - 2) / kBlockCells;
        return store_.bounds(mip)[static_cast<size_t>(by * width + bx)];
    }
    std::vector<float> readMip(int mip) {
        const int64_t width = scheme_.columnsAt(mip), height = scheme_.rowsAt(mip);
        std::vector<float> out(static_cast<size_t>(width * height));
        std::vector<float> tile(size_t{kTilePosts} * kTilePosts);
        for (int y = 0; y < scheme_.tilesY(mip); ++y) {
            for (int x = 0; x < scheme_.tilesX(mip); ++x) {
                const auto read = reader_->read({mip, x, y}, tile.data(), kTilePosts);
                EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
                for (int row = 0; row <= scheme_.cellsY({mip, x, y}); ++row) {
                    std::copy_n(tile.data() + row * kTilePosts, scheme_.cellsX({mip, x, y}) + 1,
                                out.data() + (int64_t{y} * kTileCells + row) * width +
                                    int64_t{x} * kTileCells);
                }
            }
        }
        return out;
    }
    const Store& store_;
    TilingScheme scheme_;
    std::unique_ptr<TileReader> reader_;
    std::vector<float> finest_;
    int64_t posts_ = 0;
};

TEST(Bake, LossyStoreKeepsItsErrorAndStrictBounds) {
    for (const PostFormat format : {PostFormat::Float32, PostFormat::Int16}) {
        const ArraySource source(1300, 1100, format, hills(9, true));
        const double maxError = format == PostFormat::Float32 ? 0.4 : 0.5;
        const TestFolder folder;
        bakeWell(planOf(source, maxError), folder / "a.terray");
        const auto store = opened(folder / "a.terray");
        ASSERT_NE(store, nullptr);
        StrictBounds bounds(*store);
        for (int mip = 0; mip < store->info().scheme.mipCount(); ++mip) bounds.check(mip);
        EXPECT_GT(bounds.posts(), 1300 * 1000);
        double worst = 0;
        for (int64_t j = 0; j < 1100; ++j) {
            for (int64_t i = 0; i < 1300; ++i) {
                const float in = source.at(i, j);
                const float out = bounds.finest()[static_cast<size_t>(j * 1300 + i)];
                ASSERT_EQ(std::isnan(in), std::isnan(out));
                if (std::isnan(in)) continue;
                worst =
                    std::max(worst, std::abs(static_cast<double>(in) - static_cast<double>(out)));
            }
        }
        EXPECT_LE(worst, maxError);
        EXPECT_GT(worst, maxError / 3);
    }
}

TEST(Bake, SameBytesOnAnyNumberOfThreadsAndAnyMemory) {
    const ArraySource source(1700, 1100, PostFormat::Float32, hills(2, true));
    const TestFolder folder;
    BakePlan plan = planOf(source, 0.05);
    tbb::task_arena one(1), four(4);
    one.execute([&] { bakeWell(plan, folder / "one.terray"); });
    plan.memoryBytes = 1 << 20;
    four.execute([&] { bakeWell(plan, folder / "four.terray"); });
    const auto a = filesOf(folder / "one.terray"), b = filesOf(folder / "four.terray");
    EXPECT_GT(a.size(), 10u);
    EXPECT_TRUE(a == b);
}

TEST(Bake, CoarsestMipsOfWideTerrainsHaveStrictErrors) {
    // 2^18 posts wide: mip 10 exists, whose errors are sums
    const ArraySource source((1 << 18) + 600, 2, PostFormat::Int16, [](int64_t i, int64_t) {
        return static_cast<float>(100 * std::sin(static_cast<double>(i) / 3000) +
                                  static_cast<double>(i % 7));
    });
    const TestFolder folder;
    bakeWell(planOf(source, 0.05), folder / "a.terray");
    const auto store = opened(folder / "a.terray");
    ASSERT_NE(store, nullptr);
    ASSERT_EQ(store->info().scheme.mipCount(), 11);
    StrictBounds bounds(*store);
    for (const int mip : {1, 5, 9, 10}) bounds.check(mip);
    EXPECT_LT(store->bounds(10)[0].errorToFinest, 500);
}

}  // namespace
}  // namespace terray
