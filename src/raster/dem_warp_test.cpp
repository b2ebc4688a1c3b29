// SPDX-License-Identifier: Apache-2.0
// Tests of warping on the fly: accuracy, holes, window independence, antimeridian, poles.
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "geo/frame.h"
#include "raster/test_rasters.h"

namespace terray {
namespace {

using test::RasterRecipe;
using test::textsOf;
using testing::Contains;
using testing::HasSubstr;

class DemWarpTest : public test::RasterTest {
protected:
    /// A degree raster whose samples are f(longitude, latitude) at pixel centres.
    template <class F>
    static RasterRecipe degrees(double west, double north, double step, int columns, int rows,
                                F f) {
        RasterRecipe recipe{.columns = columns, .rows = rows};
        recipe.crs = "EPSG:4326";
        recipe.transform = {west, step, 0, north, 0, -step};
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < columns; ++i) {
                recipe.values.push_back(f(west + (i + 0.5) * step, north - (j + 0.5) * step));
            }
        }
        return recipe;
    }

    static Vec2 lonLatOf(const Dem& dem, const GeoFrame& frame, int64_t i, int64_t j) {
        const Vec2 world = dem.source->info().worldFromLattice.worldFromLattice(
            {static_cast<double>(i), static_cast<double>(j)});
        const Result<Vec2> place = frame.lonLatFromWorld(world);
        EXPECT_TRUE(place);
        return *place;
    }

    static double holeShare(const Dem& dem) {
        const std::vector<float> heights = posts(dem);
        size_t holes = 0;
        for (const float z : heights) holes += std::isnan(z) ? 1 : 0;
        return static_cast<double>(holes) / static_cast<double>(heights.size());
    }
};

double hills(double lon, double lat) {
    return 1000 + 300 * std::sin(lon * 120) * std::cos(lat * 150) + 200 * std::sin(lat * 70);
}

TEST_F(DemWarpTest, PostsAreTheHeightsOfTheirPlaces) {
    const Dem dem = open(write(degrees(10.3, 46.9, 1 / 1200.0, 300, 260, hills)));
    ASSERT_TRUE(dem.facts.warped);
    EXPECT_EQ(dem.source->info().format, PostFormat::Float32);
    EXPECT_NEAR(dem.facts.workingCellX, 63.5, 0.5);  // metres of 3 seconds of longitude
    const Result<GeoFrame> frame = GeoFrame::make(dem.dataCrsWkt, dem.source->info().crsWkt);
    const std::vector<float> heights = posts(dem);
    const TilingScheme& scheme = dem.source->info().scheme;
    double worst = 0;
    int64_t seen = 0;
    for (int64_t j = 4; j < scheme.rows - 4; ++j) {
        for (int64_t i = 4; i < scheme.columns - 4; ++i) {
            const float z = heights[static_cast<size_t>(j * scheme.columns + i)];
            const Vec2 place = lonLatOf(dem, *frame, i, j);
            const bool inside = place.x > 10.3 + 0.002 && place.x < 10.55 - 0.002 &&
                                place.y < 46.9 - 0.002 && place.y > 46.9 - 260 / 1200.0 + 0.002;
            if (!inside) continue;
            ASSERT_FALSE(std::isnan(z)) << i << ' ' << j;
            worst = std::max(worst, std::abs(static_cast<double>(z) - hills(place.x, place.y)));
            ++seen;
        }
    }
    EXPECT_GT(seen, 100000);
    // Catmull-Rom on waves of 60 samples errs by 0.1 m; 0.01 samples of the map are 0.4 m here
    EXPECT_LT(worst, 0.3);
    EXPECT_THAT(textsOf(dem.facts), Contains(HasSubstr("warped to WGS 84 / UTM zone 32N")));
}

TEST_F(DemWarpTest, TheMapIsGoodToAHundredthOfASampleOverAContinent) {
    // heights count samples eastwards, then southwards: errors are places in samples
    for (const bool east : {true, false}) {
        const Dem dem = open(write(degrees(0, 70, 0.1, 350, 300, [&](double lon, double lat) {
            return 10 * (east ? lon : 70 - lat);
        })));
        ASSERT_TRUE(dem.facts.warped);
        const Result<GeoFrame> frame = GeoFrame::make(dem.dataCrsWkt, dem.source->info().crsWkt);
        const std::vector<float> heights = posts(dem);
        const TilingScheme& scheme = dem.source->info().scheme;
        double worst = 0;
        int64_t seen = 0;
        for (int64_t j = 0; j < scheme.rows; j += 3) {
            for (int64_t i = 0; i < scheme.columns; i += 3) {
                const float z = heights[static_cast<size_t>(j * scheme.columns + i)];
                const Vec2 place = lonLatOf(dem, *frame, i, j);
                if (std::isnan(z) || place.x < 0.2 || place.x > 34.8 || place.y > 69.8 ||
                    place.y < 40.2) {
                    continue;
                }
                const double exact = 10 * (east ? place.x : 70 - place.y);
                worst = std::max(worst, std::abs(static_cast<double>(z) - exact));
                ++seen;
            }
        }
        EXPECT_GT(seen, 5000);
        EXPECT_LT(worst, 0.01);
    }
}

TEST_F(DemWarpTest, AnyWindowGivesTheSameBits) {
    const Dem dem = open(write(degrees(10.3, 46.9, 1 / 1200.0, 190, 170, hills)));
    const std::vector<float> all = posts(dem);
    const TilingScheme& scheme = dem.source->info().scheme;
    std::mt19937 random(5);
    const auto draw = [&](int64_t below) {
        return std::uniform_int_distribution<int64_t>(0, below - 1)(random);
    };
    for (int round = 0; round < 40; ++round) {
        const int64_t column = draw(scheme.columns), row = draw(scheme.rows);
        const int64_t width = 1 + draw(scheme.columns - column),
                      height = 1 + draw(scheme.rows - row);
        std::vector<float> part(static_cast<size_t>(width * height));
        Result<std::unique_ptr<HeightReader>> reader = dem.source->makeReader();
        ASSERT_TRUE((*reader)->read(column, row, width, height, part));
        for (int64_t j = 0; j < height; ++j) {
            for (int64_t i = 0; i < width; ++i) {
                const float a = part[static_cast<size_t>(j * width + i)];
                const float b = all[static_cast<size_t>((row + j) * scheme.columns + column + i)];
                ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
            }
        }
    }
}

TEST_F(DemWarpTest, HolesNeitherBleedNorRing) {
    constexpr double kNodata = -9999;
    RasterRecipe recipe = degrees(10, 47, 0.001, 120, 100, [](double lon, double) {
        return lon < 10.06 ? 100.0 : 500.0;  // a cliff
    });
    for (int j = 0; j < 100; ++j) {
        for (int i = 0; i < 120; ++i) {
            const bool isHole = (i + 3 * j) % 17 == 0 || (i > 55 && i < 60) ||
                                (i - 30) * (i - 30) + (j - 50) * (j - 50) < 90;
            if (isHole) recipe.values[static_cast<size_t>(j * 120 + i)] = kNodata;
        }
    }
    recipe.nodata = kNodata;
    const std::string file = write(recipe);
    const std::vector<float> heights = posts(open(file));
    size_t low = 0, high = 0;
    for (const float z : heights) {
        if (std::isnan(z)) continue;
        // no row of four valid samples crosses the cliff beside the holes: nothing in between, and
        // nothing beyond; bilinear means of equal heights are exact
        low += z == 100;
        high += z == 500;
        EXPECT_TRUE(z == 100 || z == 500 || (z > 71 && z < 529)) << z;
    }
    EXPECT_GT(low, heights.size() / 4);
    EXPECT_GT(high, heights.size() / 4);
}

TEST_F(DemWarpTest, HolesKeepTheirSize) {
    RasterRecipe recipe = degrees(10, 47, 0.001, 100, 100, [](double, double) { return 5.0; });
    for (int j = 40; j < 60; ++j) {
        for (int i = 40; i < 60; ++i) recipe.values[static_cast<size_t>(j * 100 + i)] = -1;
    }
    recipe.nodata = -1;
    const Dem dem = open(write(recipe));
    recipe.nodata.reset();
    const Dem whole = open(write(recipe, "whole.tif"));
    EXPECT_NEAR(holeShare(dem) - holeShare(whole), 0.04, 0.004);  // 20 x 20 of 100 x 100
}

TEST_F(DemWarpTest, WebMercatorIsWarpedUnlessTold) {
    RasterRecipe recipe{.columns = 40, .rows = 40};
    recipe.crs = "EPSG:3857";
    recipe.transform = {1.2e6, 30, 0, 6e6, 0, -30};
    const std::string file = write(recipe);
    const Dem dem = open(file);
    EXPECT_TRUE(dem.facts.warped);
    EXPECT_NEAR(dem.facts.workingCellX, 30 * std::cos(radFromDeg(47.3)), 0.2);
    OpenOptions options;
    options.workingCrs = "EPSG:3857";
    const Dem kept = open(file, options);
    EXPECT_FALSE(kept.facts.warped);
    EXPECT_EQ(kept.facts.workingCellX, 30);
}

TEST_F(DemWarpTest, TheSmallestGeographicRasterHasACell) {
    const Dem dem = open(write(degrees(10, 47, 0.001, 2, 2, [](double, double) { return 7.0; })));
    const TilingScheme& scheme = dem.source->info().scheme;
    const std::vector<float> heights = posts(dem);
    bool hasCell = false;
    for (int64_t j = 0; j + 1 < scheme.rows; ++j) {
        for (int64_t i = 0; i + 1 < scheme.columns; ++i) {
            const auto k = static_cast<size_t>(j * scheme.columns + i);
            const size_t below = k + static_cast<size_t>(scheme.columns);
            hasCell |= heights[k] == 7 && heights[k + 1] == 7 && heights[below] == 7 &&
                       heights[below + 1] == 7;
        }
    }
    EXPECT_TRUE(hasCell);
}

TEST_F(DemWarpTest, RastersAcrossTheAntimeridianAreWhole) {
    for (const double west : {179.5, -180.5, 359.7, 200.0, -0.3}) {
        SCOPED_TRACE(west);
        const Dem dem =
            open(write(degrees(west, -16, 0.01, 100, 80, [](double lon, double) { return lon; })));
        EXPECT_LT(holeShare(dem), 0.06);
        const std::vector<float> heights = posts(dem);
        const auto columns = static_cast<size_t>(dem.source->info().scheme.columns);
        const size_t middle = heights.size() / 2 / columns * columns;
        for (size_t i = 4; i + 5 < columns; ++i) {  // heights grow eastwards, without a jump
            EXPECT_NEAR(heights[middle + i + 1] - heights[middle + i], 0.01, 0.002);
        }
    }
}

TEST_F(DemWarpTest, PolarCapsAreWholeAndTheGlobeIsRefused) {
    const Dem cap =
        open(write(degrees(-180, 90, 0.5, 720, 20, [](double, double lat) { return 100 * lat; })));
    const std::vector<float> heights = posts(cap);
    const TilingScheme& scheme = cap.source->info().scheme;
    const auto centre = static_cast<size_t>(scheme.rows / 2 * scheme.columns + scheme.columns / 2);
    EXPECT_NEAR(heights[centre], 8975, 30);  // the pole: no hole, its ring of samples around it
    EXPECT_LT(holeShare(cap), 0.24);         // a disc in its square leaves 0.215
    const Error error = failure(
        write(degrees(-180, 90, 1, 360, 180, [](double, double) { return 0.0; }), "globe.tif"));
    EXPECT_EQ(error.code, ErrorCode::Input);
    EXPECT_THAT(error.message, HasSubstr("cut a window"));
}

TEST_F(DemWarpTest, EncodedAndScaledHeightsAreWarpedAsHeights) {
    RasterRecipe recipe{.columns = 30, .rows = 30, .type = GDT_Int16};
    recipe.crs = "EPSG:4326";
    recipe.transform = {10, 0.001, 0, 47, 0, -0.001};
    recipe.values.assign(900, 100);
    recipe.scale = 0.5;
    recipe.unit = "ft";
    for (const float z : posts(open(write(recipe)))) {
        if (std::isnan(z)) continue;
        EXPECT_EQ(z, static_cast<float>(50 * 0.3048));
    }
    RasterRecipe colours = recipe;
    colours.bands = 3;
    colours.type = GDT_Byte;
    colours.scale.reset();
    colours.values.assign(900, 1);
    colours.values.resize(1800, 200);
    colours.values.resize(2700, 3);
    OpenOptions options;
    options.encoding = HeightEncoding::TerrainRgb;
    for (const float z : posts(open(write(colours, "rgb.tif"), options))) {
        if (std::isnan(z)) continue;
        EXPECT_EQ(z, static_cast<float>(-10000 + 0.1 * (65536 + 51200 + 3)));
    }
}

}  // namespace
}  // namespace terray
