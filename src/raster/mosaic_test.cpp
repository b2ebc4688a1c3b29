// SPDX-License-Identifier: Apache-2.0
// DEMs joined on one lattice: last named on top, holes between, nothing else taken for alike.
#include "raster/mosaic.h"

#include <cmath>

#include "raster/test_rasters.h"

namespace terray {
namespace {

class MosaicTest : public test::RasterTest {
protected:
    /// Columns x rows of one height, from pixel (i, j) of a common lattice of 10 m.
    std::string flat(const std::string& name, int i, int j, double height,
                     test::RasterRecipe recipe = {}) {
        recipe.values.assign(static_cast<size_t>(recipe.columns * recipe.rows), height);
        if (recipe.nodata) recipe.values[0] = *recipe.nodata;
        recipe.transform = std::array<double, 6>{5e5 + 10 * i, 10, 0, 4e6 - 10 * j, 0, -10};
        return write(recipe, name);
    }
    /// All heights of the joined DEM, row by row.
    std::vector<float> joined(const std::vector<std::string>& names, int64_t& columns,
                              const OpenOptions& options = {}) {
        auto mosaic = Mosaic::join(names, options);
        EXPECT_TRUE(mosaic.ok()) << (mosaic.ok() ? "" : mosaic.error().message);
        auto dem = openDem((*mosaic)->path(), options, RangeScan::Always);
        EXPECT_TRUE(dem.ok()) << (dem.ok() ? "" : dem.error().message);
        const TilingScheme scheme = dem->source->info().scheme;
        columns = scheme.columns;
        std::vector<float> posts(static_cast<size_t>(scheme.columns * scheme.rows));
        auto reader = dem->source->makeReader();
        EXPECT_TRUE((*reader)->read(0, 0, scheme.columns, scheme.rows, posts).ok());
        return posts;
    }
    void expectUnlike(const std::vector<std::string>& names, const OpenOptions& options = {}) {
        const auto mosaic = Mosaic::join(names, options);
        ASSERT_TRUE(mosaic.ok()) << mosaic.error().message;
        EXPECT_EQ(*mosaic, nullptr) << names.back();
    }
};

TEST_F(MosaicTest, LastNamedWinsAndGapsAreHoles) {
    for (const GDALDataType type : {GDT_Float32, GDT_Int16}) {
        for (const std::optional<double> nodata :
             {std::optional<double>(), std::optional<double>(-99)}) {
            test::RasterRecipe recipe;
            recipe.type = type;
            recipe.nodata = nodata;
            const std::string a = flat("a.tif", 0, 0, 1, recipe),
                              b = flat("b.tif", 2, 0, 2, recipe);
            const std::string c = flat("c.tif", 9, 1, 3, recipe);
            int64_t columns = 0;
            const auto posts = joined({c, b, a}, columns);
            ASSERT_EQ(columns, 13);
            ASSERT_EQ(posts.size(), 13u * 4u);
            EXPECT_EQ(posts[1], 1);
            EXPECT_EQ(posts[2], 1);  // a and b have it
            EXPECT_EQ(posts[5], 2);
            EXPECT_TRUE(std::isnan(posts[7]));
            EXPECT_EQ(posts[13 + 10], 3);
            EXPECT_EQ(std::isnan(posts[0]), nodata.has_value());
            const auto swapped = joined({c, a, b}, columns);
            EXPECT_EQ(swapped[3], 2);
            EXPECT_EQ(swapped[2], nodata ? 1 : 2);  // a hole of b shows a
        }
    }
}

TEST_F(MosaicTest, WhatIsUnlikeIsLeftToWarping) {
    const std::string a = flat("a.tif", 0, 0, 1);
    test::RasterRecipe other;
    other.crs = "EPSG:32632";
    expectUnlike({a, flat("crs.tif", 4, 0, 1, other)});
    other = {};
    other.type = GDT_Int16;
    expectUnlike({a, flat("type.tif", 4, 0, 1, other)});
    other = {};
    other.unit = "ft";
    expectUnlike({a, flat("unit.tif", 4, 0, 1, other)});
    other = {};
    other.nodata = -5;
    expectUnlike({a, flat("nodata.tif", 4, 0, 1, other)});
    other = {};
    other.values.assign(12, 1);
    other.transform = std::array<double, 6>{5e5 + 43, 10, 0, 4e6, 0, -10};
    expectUnlike({a, write(other, "shifted.tif")});
    other.transform = std::array<double, 6>{5e5 + 40, 5, 0, 4e6, 0, -5};
    expectUnlike({a, write(other, "finer.tif")});
    const auto missing = Mosaic::join(std::vector<std::string>{a, path("missing.tif")}, {});
    ASSERT_FALSE(missing.ok());
    EXPECT_NE(missing.error().message.find("missing.tif"), std::string::npos);
    OpenOptions options;
    options.encoding = HeightEncoding::TerrainRgb;
    expectUnlike({a, a}, options);
}

}  // namespace
}  // namespace terray
