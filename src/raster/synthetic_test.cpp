// SPDX-License-Identifier: Apache-2.0
// Tests of the synthetic terrains: determinism, character, formats and names.
#include "raster/synthetic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

namespace terray {
namespace {

using testing::HasSubstr;
using Maker = std::unique_ptr<HeightSource> (*)(const SyntheticOptions&);

std::vector<float> readWindow(const HeightSource& source, int64_t column, int64_t row,
                              int64_t width, int64_t height) {
    std::vector<float> posts(static_cast<size_t>(width * height));
    auto reader = source.makeReader();
    EXPECT_TRUE(reader);
    EXPECT_TRUE((*reader)->read(column, row, width, height, posts));
    return posts;
}

std::vector<float> readAll(const HeightSource& source) {
    return readWindow(source, 0, 0, source.info().scheme.columns, source.info().scheme.rows);
}

bool isSame(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Share of a square's cells whose gradient at the middle is steeper than an angle.
double steepShare(const std::vector<float>& z, int64_t side, double cell, double angleDeg) {
    const double limit = std::tan(radFromDeg(angleDeg));
    int64_t steep = 0;
    for (int64_t j = 0; j + 1 < side; ++j) {
        for (int64_t i = 0; i + 1 < side; ++i) {
            const float* p = &z[static_cast<size_t>(j * side + i)];
            const double east = (p[1] - p[0] + p[side + 1] - p[side]) / 2 / cell;
            const double south = (p[side] - p[0] + p[side + 1] - p[1]) / 2 / cell;
            if (std::hypot(east, south) > limit) ++steep;
        }
    }
    return static_cast<double>(steep) / static_cast<double>((side - 1) * (side - 1));
}

class Synthetic : public testing::TestWithParam<Maker> {};

TEST_P(Synthetic, AWindowDoesNotDependOnHowItIsRead) {
    for (const double cell : {0.5, 1.0, 10.0, 33.3}) {
        const auto whole = GetParam()({700, 600, cell, 5, PostFormat::Float32});
        const auto wide = GetParam()({3000, 2000, cell, 5, PostFormat::Float32});
        const std::vector<float> all = readAll(*whole);
        std::mt19937 random(11);
        for (int k = 0; k < 20; ++k) {
            const int64_t width = 1 + random() % 200, height = 1 + random() % 100;
            const int64_t column = random() % (700 - width), row = random() % (600 - height);
            const std::vector<float> part = readWindow(*wide, column, row, width, height);
            for (int64_t j = 0; j < height; ++j) {
                for (int64_t i = 0; i < width; ++i) {
                    const float a = all[static_cast<size_t>((row + j) * 700 + column + i)];
                    const float b = part[static_cast<size_t>(j * width + i)];
                    ASSERT_TRUE(isSame(a, b)) << a << " " << b << " cell " << cell;
                }
            }
        }
    }
}

TEST_P(Synthetic, CodesAndHeightsAgreeExactly) {
    const auto source = GetParam()({513, 400, 1, 2, PostFormat::Int16});
    EXPECT_EQ(source->info().format, PostFormat::Int16);
    EXPECT_EQ(source->info().zStep, 0.05f);
    const auto exact = GetParam()({513, 400, 1, 2, PostFormat::Float32});
    const std::vector<float> heights = readAll(*source), unrounded = readAll(*exact);
    std::vector<uint16_t> codes(heights.size());
    auto reader = source->makeReader();
    ASSERT_TRUE((*reader)->readCodes(0, 0, 513, 400, codes));
    for (size_t k = 0; k < codes.size(); ++k) {
        ASSERT_EQ(codes[k] == kHolePost, std::isnan(unrounded[k]));
        if (codes[k] == kHolePost) {
            ASSERT_TRUE(std::isnan(heights[k]));
            continue;
        }
        const float decoded =
            source->info().z0 + source->info().zStep * static_cast<float>(codes[k]);
        ASSERT_EQ(heights[k], decoded);
        ASSERT_NEAR(unrounded[k], decoded, 0.0252);
    }
}

TEST_P(Synthetic, StaysWithinItsStatedRangeAndDependsOnTheSeed) {
    const auto source = GetParam()({1500, 1500, 5, 9, PostFormat::Float32});
    const auto other = GetParam()({1500, 1500, 5, 10, PostFormat::Float32});
    const std::vector<float> z = readAll(*source), w = readAll(*other);
    size_t different = 0;
    for (size_t k = 0; k < z.size(); ++k) {
        if (!isSame(z[k], w[k])) ++different;
        if (std::isnan(z[k])) continue;
        ASSERT_GE(z[k], source->info().minZ);
        ASSERT_LE(z[k], source->info().maxZ);
    }
    EXPECT_GT(different, z.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Synthetic, testing::Values(&makeFractal, &makeTown));

TEST(Fractal, IsSteepAndFillsItsRange) {
    const auto source = makeFractal({4096, 4096, 10, 1, PostFormat::Float32});
    const std::vector<float> z = readWindow(*source, 1024, 1024, 2048, 2048);
    const double share = steepShare(z, 2048, 10, 60);
    EXPECT_GT(share, 0.20);
    EXPECT_LT(share, 0.32);
    const auto [lowest, highest] = std::minmax_element(z.begin(), z.end());
    EXPECT_LT(*lowest, 200);
    EXPECT_GT(*highest, 2400);
}

TEST(Fractal, HasTheSameCharacterEverywhere) {
    for (const uint32_t seed : {1u, 77u}) {
        const auto source = makeFractal({1 << 20, 1 << 20, 10, seed, PostFormat::Float32});
        for (const int64_t place : {0, 123457, 1000000}) {
            const std::vector<float> z = readWindow(*source, place, place / 2, 1024, 1024);
            const double share = steepShare(z, 1024, 10, 60);
            EXPECT_GT(share, 0.14) << seed << " " << place;
            EXPECT_LT(share, 0.40) << seed << " " << place;
        }
    }
}

// the bits are part of the promise: benches and exactness runs on any machine see this ground
TEST(Fractal, IsTheSameOnEveryMachine) {
    const auto source = makeFractal({4096, 4096, 10, 1, PostFormat::Float32});
    uint64_t hash = 1469598103934665603u;  // FNV-1a over the values' bits
    for (const float z : readWindow(*source, 300, 2000, 256, 256)) {
        uint32_t bits;
        static_assert(sizeof bits == sizeof z);
        std::memcpy(&bits, &z, sizeof bits);
        hash = (hash ^ bits) * 1099511628211u;
    }
    EXPECT_EQ(hash, 13982218828304967411u);
}

TEST(Town, HasCliffsTreesAndHoles) {
    const auto source = makeTown({2048, 2048, 1, 1, PostFormat::Float32});
    const std::vector<float> z = readAll(*source);
    size_t holes = 0, cliffs = 0, level = 0;
    for (size_t k = 0; k + 1 < z.size(); ++k) {
        if (std::isnan(z[k])) ++holes;
        if (std::abs(z[k + 1] - z[k]) > 3) ++cliffs;
        if (std::abs(z[k + 1] - z[k]) < 0.2f) ++level;
    }
    EXPECT_GT(holes, z.size() / 100);
    EXPECT_LT(holes, z.size() / 10);
    EXPECT_GT(cliffs, z.size() / 200);
    EXPECT_GT(level, z.size() / 2);
    EXPECT_GT(*std::max_element(z.begin(), z.end(),
                                [](float a, float b) {
                                    return (std::isnan(a) ? 0 : a) < (std::isnan(b) ? 0 : b);
                                }),
              80);
}

TEST(SyntheticName, IsParsed) {
    const auto source =
        makeSynthetic("synthetic:fractal?rows=70&size=4096&cell=2.5&seed=9&format=int16");
    ASSERT_TRUE(source) << source.error().message;
    const TerrainInfo& info = (*source)->info();
    EXPECT_EQ(info.scheme.columns, 4096);
    EXPECT_EQ(info.scheme.rows, 70);
    EXPECT_EQ(info.format, PostFormat::Int16);
    EXPECT_EQ(info.worldFromLattice.columnLength(), 2.5);
    EXPECT_EQ(info.worldFromLattice.worldFromLattice({0, 69}), Vec2(0, 0));
    EXPECT_TRUE(info.crsWkt.empty());
    const auto direct = makeFractal({4096, 70, 2.5, 9, PostFormat::Int16});
    EXPECT_EQ(readWindow(**source, 5, 5, 50, 50), readWindow(*direct, 5, 5, 50, 50));
    EXPECT_EQ((*makeSynthetic("synthetic:town"))->info().worldFromLattice.columnLength(), 1);
}

TEST(SyntheticName, IsNullForFilesAndAnErrorWhenWrong) {
    const auto file = makeSynthetic("dem.tif");
    ASSERT_TRUE(file);
    EXPECT_EQ(file->get(), nullptr);
    for (const char* bad :
         {"synthetic:", "synthetic:sea", "synthetic:fractal?size=1",
          "synthetic:fractal?size=", "synthetic:fractal?size=1e9", "synthetic:fractal?cell=0",
          "synthetic:fractal?cell=nan", "synthetic:fractal?cell=inf", "synthetic:fractal?seed=-1",
          "synthetic:fractal?colour=red", "synthetic:fractal?format=int8", "synthetic:fractal?size",
          "synthetic:fractal?=5", "synthetic:fractal?rows=99999999999999999999"}) {
        const auto source = makeSynthetic(bad);
        ASSERT_FALSE(source) << bad;
        EXPECT_EQ(source.error().code, ErrorCode::Usage);
        EXPECT_THAT(source.error().message, HasSubstr("synthetic:"));
    }
}

}  // namespace
}  // namespace terray
