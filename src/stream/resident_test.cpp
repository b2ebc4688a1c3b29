// SPDX-License-Identifier: Apache-2.0
// Tests of resident terrains: posts, shared edges, nesting, errors against brute force, refusals.
#include "stream/resident.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/interrupt.h"
#include "kernel/height.h"
#include "stream/cut.h"
#include "stream/test_source.h"

namespace terray {
namespace {

using test::ArraySource;
using test::built;
using test::hills;
using test::kNaN;

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Decoded posts of a terrain, by lattice place of a mip.
class Posts {
public:
    explicit Posts(const ResidentTerrain& terrain)
        : terrain_(terrain), frame_(finestCut(terrain, kSurfaceBilinear)) {}
    const TerrainCut& cut() const { return frame_.cut(); }
    float inTile(TileId id, int i, int j) const {
        return postHeight(cut(), cut().tiles[terrain_.slotOf(id)], i, j);
    }
    /// Post (i, j) of a mip, from the tile to its lower right where there is one.
    float at(int mip, int64_t i, int64_t j) const {
        const TilingScheme& scheme = terrain_.info().scheme;
        const int x = std::min(static_cast<int>(i / 512), scheme.tilesX(mip) - 1);
        const int y = std::min(static_cast<int>(j / 512), scheme.tilesY(mip) - 1);
        return inTile({mip, x, y}, static_cast<int>(i - x * 512), static_cast<int>(j - y * 512));
    }

private:
    const ResidentTerrain& terrain_;
    FrameCut frame_;
};

struct Case {
    int64_t columns, rows;
    PostFormat format;
    bool holes;
};

class Resident : public testing::TestWithParam<Case> {
protected:
    ArraySource source_{GetParam().columns, GetParam().rows, GetParam().format,
                        hills(3, GetParam().holes)};
    std::unique_ptr<ResidentTerrain> terrain_ = built(source_);
    const TilingScheme& scheme() const { return terrain_->info().scheme; }
};

TEST_P(Resident, FinestPostsEqualTheSourceBitForBit) {
    ASSERT_NE(terrain_, nullptr);
    const Posts posts(*terrain_);
    for (int y = 0; y < scheme().tilesY(0); ++y) {
        for (int x = 0; x < scheme().tilesX(0); ++x) {
            for (int j = 0; j <= 512 && y * 512 + j < scheme().rows; ++j) {
                for (int i = 0; i <= 512 && x * 512 + i < scheme().columns; ++i) {
                    ASSERT_TRUE(
                        same(posts.inTile({0, x, y}, i, j), source_.at(x * 512 + i, y * 512 + j)))
                        << x << ' ' << y << ' ' << i << ' ' << j;
                }
            }
        }
    }
}

TEST_P(Resident, NeighboursShareTheirEdgePosts) {
    const Posts posts(*terrain_);
    for (int mip = 0; mip < terrain_->mipCount(); ++mip) {
        for (int64_t y = 0; y < scheme().rowsAt(mip); ++y) {
            for (int x = 1; x < scheme().tilesX(mip); ++x) {
                const int tileY = std::min(static_cast<int>(y / 512), scheme().tilesY(mip) - 1);
                const int j = static_cast<int>(y - tileY * 512);
                ASSERT_TRUE(same(posts.inTile({mip, x - 1, tileY}, 512, j),
                                 posts.inTile({mip, x, tileY}, 0, j)));
            }
        }
        for (int64_t x = 0; x < scheme().columnsAt(mip); ++x) {
            for (int y = 1; y < scheme().tilesY(mip); ++y) {
                const int tileX = std::min(static_cast<int>(x / 512), scheme().tilesX(mip) - 1);
                const int i = static_cast<int>(x - tileX * 512);
                ASSERT_TRUE(same(posts.inTile({mip, tileX, y - 1}, i, 512),
                                 posts.inTile({mip, tileX, y}, i, 0)));
            }
        }
    }
}

TEST_P(Resident, CoarsePostsAreValidWhereTheFinestPostIs) {
    const Posts posts(*terrain_);
    for (int mip = 1; mip < terrain_->mipCount(); ++mip) {
        for (int64_t j = 0; j < scheme().rowsAt(mip); ++j) {
            for (int64_t i = 0; i < scheme().columnsAt(mip); ++i) {
                const float below = source_.at(std::min(i << mip, scheme().columns - 1),
                                               std::min(j << mip, scheme().rows - 1));
                ASSERT_EQ(std::isnan(posts.at(mip, i, j)), std::isnan(below));
            }
        }
    }
}

/// Bilinear height of a mip at a post of mip 0; NaN if a post that bears on it is a hole.
double heightAt(const Posts& posts, int mip, int64_t i, int64_t j) {
    const int64_t x = i >> mip, y = j >> mip;
    const double size = std::ldexp(1.0, mip);
    const double u = static_cast<double>(i - (x << mip)) / size;
    const double v = static_cast<double>(j - (y << mip)) / size;
    double sum = 0;
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        const double weight = (dx != 0 ? u : 1 - u) * (dy != 0 ? v : 1 - v);
        if (weight != 0) sum += weight * static_cast<double>(posts.at(mip, x + dx, y + dy));
    }
    return sum;
}

TEST_P(Resident, BlockErrorsAreExact) {
    const Posts posts(*terrain_);
    for (int mip = 0; mip < terrain_->mipCount(); ++mip) {
        const int64_t size = int64_t{64} << mip;
        for (int64_t y = 0; y * size < scheme().rows - 1; ++y) {
            for (int64_t x = 0; x * size < scheme().columns - 1; ++x) {
                double worst = 0;
                for (int64_t j = y * size; j <= std::min((y + 1) * size, scheme().rows - 1); ++j) {
                    for (int64_t i = x * size; i <= std::min((x + 1) * size, scheme().columns - 1);
                         ++i) {
                        const double error = std::abs(heightAt(posts, mip, i, j) -
                                                      static_cast<double>(source_.at(i, j)));
                        if (error > worst) worst = error;
                    }
                }
                const uint32_t slot =
                    terrain_->slotOf({mip, static_cast<int>(x / 8), static_cast<int>(y / 8)});
                const BlockBounds& block =
                    terrain_->blocks(slot)[static_cast<size_t>(y % 8 * 8 + x % 8)];
                ASSERT_GE(static_cast<double>(block.errorToFinest), worst - 1e-9)
                    << mip << ' ' << x << ' ' << y;
                ASSERT_LE(static_cast<double>(block.errorToFinest), worst + 1e-3);
            }
        }
    }
}

/// Whether the cell of a mip over the finest cell (i, j) exists.
bool cellExists(const Posts& posts, int mip, int64_t i, int64_t j) {
    const int64_t x = i >> mip, y = j >> mip;
    return !std::isnan(posts.at(mip, x, y) + posts.at(mip, x + 1, y) + posts.at(mip, x, y + 1) +
                       posts.at(mip, x + 1, y + 1));
}

TEST_P(Resident, CoverageThatDiffersIsSaid) {
    const Posts posts(*terrain_);
    for (int mip = 1; mip < terrain_->mipCount(); ++mip) {
        for (int64_t j = 0; j < scheme().rows - 1; ++j) {
            for (int64_t i = 0; i < scheme().columns - 1; ++i) {
                const int64_t x = (i >> mip) / 64, y = (j >> mip) / 64;
                const uint32_t slot =
                    terrain_->slotOf({mip, static_cast<int>(x / 8), static_cast<int>(y / 8)});
                const BlockBounds& block =
                    terrain_->blocks(slot)[static_cast<size_t>(y % 8 * 8 + x % 8)];
                if (cellExists(posts, mip, i, j) != cellExists(posts, 0, i, j)) {
                    ASSERT_GE(block.coverageError, 14.1f * std::ldexp(1.0f, mip));
                }
                if (!GetParam().holes) {
                    ASSERT_EQ(block.coverageError, 0);
                }
            }
        }
    }
}

TEST_P(Resident, TilesKnowTheirPlace) {
    const Posts posts(*terrain_);
    for (int mip = 0; mip < terrain_->mipCount(); ++mip) {
        for (int y = 0; y < scheme().tilesY(mip); ++y) {
            for (int x = 0; x < scheme().tilesX(mip); ++x) {
                const TileDesc& tile = posts.cut().tiles[terrain_->slotOf({mip, x, y})];
                EXPECT_EQ(tile.x, x * 512 << mip);
                EXPECT_EQ(tile.y, y * 512 << mip);
                EXPECT_EQ(tile.mipFlags & kTileMipMask, static_cast<uint32_t>(mip));
            }
        }
    }
    EXPECT_EQ(terrain_->slotOf({terrain_->mipCount(), 0, 0}), kNoSlot);
    EXPECT_EQ(terrain_->slotOf({0, -1, 0}), kNoSlot);
    EXPECT_EQ(terrain_->slotOf({0, scheme().tilesX(0), 0}), kNoSlot);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Resident,
                         testing::Values(Case{2, 2, PostFormat::Float32, false},
                                         Case{2, 700, PostFormat::Int16, true},
                                         Case{513, 513, PostFormat::Int16, false},
                                         Case{514, 514, PostFormat::Float32, true},
                                         Case{1031, 769, PostFormat::Int16, true},
                                         Case{1500, 523, PostFormat::Float32, true},
                                         Case{2049, 600, PostFormat::Float32, false}),
                         [](const auto& testCase) {
                             const Case& c = testCase.param;
                             return std::to_string(c.columns) + "x" + std::to_string(c.rows) +
                                    (c.format == PostFormat::Int16 ? "Int16" : "Float") +
                                    (c.holes ? "Holes" : "");
                         });

TEST(ResidentTerrain, RangeAndHolesAreThoseOfTheSource) {
    for (const PostFormat format : {PostFormat::Int16, PostFormat::Float32}) {
        const ArraySource source(800, 600, format, hills(5, true));
        float low = 1e9f, high = -1e9f;
        uint64_t holes = 0;
        for (int64_t j = 0; j < 600; ++j) {
            for (int64_t i = 0; i < 800; ++i) {
                const float z = source.at(i, j);
                if (std::isnan(z)) {
                    ++holes;
                    continue;
                }
                low = std::min(low, z);
                high = std::max(high, z);
            }
        }
        BuildStats stats;
        const auto terrain = ResidentTerrain::build(source, uint64_t{1} << 30, stats);
        ASSERT_TRUE(terrain.ok());
        EXPECT_EQ(terrain.value()->info().minZ, low);
        EXPECT_EQ(terrain.value()->info().maxZ, high);
        EXPECT_EQ(stats.holes, holes);
    }
}

TEST(ResidentTerrain, AllHolesIsATerrainWithNothingToHit) {
    for (const PostFormat format : {PostFormat::Int16, PostFormat::Float32}) {
        const ArraySource source(700, 520, format, [](int64_t, int64_t) { return kNaN; });
        const auto terrain = built(source);
        ASSERT_NE(terrain, nullptr);
        const FrameCut cut = finestCut(*terrain, kSurfaceBilinear);
        EXPECT_EQ(cut.cut().squares[cut.cut().levels[cut.cut().rootLevel].offset].state,
                  kSquareEmpty);
        EXPECT_EQ(surfaceCellAt(cut.cut(), 100, 100).slot, kNoSlot);
    }
}

TEST(ResidentTerrain, InfiniteHeightsBecomeHoles) {
    const ArraySource source(4, 4, PostFormat::Float32, [](int64_t i, int64_t j) {
        return i == 1 && j == 2 ? std::numeric_limits<float>::infinity() : 5.0f;
    });
    const auto terrain = built(source);
    ASSERT_NE(terrain, nullptr);
    EXPECT_TRUE(std::isnan(Posts(*terrain).at(0, 1, 2)));
    EXPECT_EQ(terrain->info().maxZ, 5.0f);
}

/// 4.69 and 7.41 bytes, and half a byte for windows that are worked on. A whole process may take 5
/// and 8 bytes above that of a 2 x 2 DEM (bench/whole_process.py), and sky light needs its share of
/// that.
TEST(ResidentMemory, IsAFewBytesASampleWithAllMipsAndBounds) {
    for (const PostFormat format : {PostFormat::Int16, PostFormat::Float32}) {
        TerrainInfo info;
        info.scheme = {4096, 4096};
        info.format = format;
        const double perSample =
            static_cast<double>(ResidentTerrain::requiredBytes(info)) / (4096.0 * 4096.0);
        EXPECT_LE(perSample, format == PostFormat::Int16 ? 5.2 : 7.92);
        EXPECT_GE(perSample, format == PostFormat::Int16 ? 5.0 : 7.7);
    }
}

TEST(ResidentTerrain, RefusesWhatDoesNotFit) {
    ArraySource source(600, 600, PostFormat::Float32, hills(7, false));
    BuildStats stats;
    const uint64_t needed = ResidentTerrain::requiredBytes(source.info());
    EXPECT_TRUE(ResidentTerrain::build(source, needed, stats).ok());
    const auto tooSmall = ResidentTerrain::build(source, needed - 1, stats);
    ASSERT_FALSE(tooSmall.ok());
    EXPECT_EQ(tooSmall.error().code, ErrorCode::Input);
    EXPECT_NE(tooSmall.error().message.find("--memory"), std::string::npos);

    // Decided from the header, before anything is read or allocated.
    source.info().scheme = {int64_t{1} << 30, int64_t{1} << 30};
    const auto huge = ResidentTerrain::build(source, ~uint64_t{0}, stats);
    ASSERT_FALSE(huge.ok());
    EXPECT_EQ(huge.error().code, ErrorCode::Input);
    source.info().scheme = {60000, 60000};
    EXPECT_FALSE(ResidentTerrain::build(source, ~uint64_t{0}, stats).ok());
}

TEST(ResidentTerrain, PassesOnReadErrorsAndInterrupts) {
    ArraySource source(600, 600, PostFormat::Int16, hills(9, false));
    BuildStats stats;
    source.failAtRow(431);
    const auto failed = ResidentTerrain::build(source, uint64_t{1} << 30, stats);
    ASSERT_FALSE(failed.ok());
    EXPECT_EQ(failed.error().message, "row cannot be read");
    source.failAtRow(-1);
    setInterrupted(true);
    const auto interrupted = ResidentTerrain::build(source, uint64_t{1} << 30, stats);
    setInterrupted(false);
    ASSERT_FALSE(interrupted.ok());
    EXPECT_EQ(interrupted.error().code, ErrorCode::Interrupted);
}

}  // namespace
}  // namespace terray
