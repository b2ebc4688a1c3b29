// SPDX-License-Identifier: Apache-2.0
// Unlike DEMs on one lattice: the heights of each at their places, last named on top, holes
// between.
#include "raster/dem_mosaic.h"

#include <cmath>

#include "geo/frame.h"
#include "raster/test_rasters.h"

namespace terray {
namespace {

constexpr const char* kZone33 = "EPSG:32633";

/// A plane over zone 33: filters give it back as it is.
double plane(Vec2 p) { return 100 + 0.02 * (p.x - 5e5) - 0.03 * (p.y - 4e6); }

class DemMosaicTest : public test::RasterTest {
protected:
    /// The plane (plus `lift`) on north-up pixels of any CRS.
    std::string slope(const std::string& name, int columns, int rows,
                      const std::array<double, 6>& t, test::RasterRecipe recipe = {},
                      double lift = 0) {
        recipe.columns = columns, recipe.rows = rows;
        recipe.transform = t;
        const auto frame = GeoFrame::make(describeCrs(recipe.crs)->wkt, describeCrs(kZone33)->wkt);
        EXPECT_TRUE(frame.ok());
        for (int j = 0; j < rows; ++j) {
            for (int i = 0; i < columns; ++i) {
                const auto p =
                    frame->worldFromData({t[0] + (i + 0.5) * t[1], t[3] + (j + 0.5) * t[5]});
                recipe.values.push_back((plane(*p) + lift) / metres_);
            }
        }
        return write(recipe, name);
    }
    void open(const std::vector<std::string>& names, const OpenOptions& options = {}) {
        auto dem = openUnlikeDems(names, options);
        ASSERT_TRUE(dem.ok()) << dem.error().message;
        dem_ = std::move(*dem);
        const TilingScheme scheme = dem_.source->info().scheme;
        posts_.resize(static_cast<size_t>(scheme.columns * scheme.rows));
        auto reader = dem_.source->makeReader();
        ASSERT_TRUE((*reader)->read(0, 0, scheme.columns, scheme.rows, posts_).ok());
    }
    /// Height less the plane's at the post nearest to a place of zone 33.
    double above(double x, double y) const {
        const TerrainInfo& info = dem_.source->info();
        const LatticePoint p = info.worldFromLattice.latticeFromWorld({x, y});
        const double i = std::round(p.i), j = std::round(p.j);
        const auto at = static_cast<int64_t>(j) * info.scheme.columns + static_cast<int64_t>(i);
        return static_cast<double>(posts_.at(static_cast<size_t>(at))) -
               plane(info.worldFromLattice.worldFromLattice({i, j}));
    }

    double metres_ = 1;  ///< of the unit that slope() writes
    Dem dem_;
    std::vector<float> posts_;
};

TEST_F(DemMosaicTest, FinestLatticeLastOnTopHolesBetween) {
    const std::string coarse = slope("coarse.tif", 30, 30, {5e5, 10, 0, 4e6, 0, -10});
    test::RasterRecipe holed;
    holed.nodata = -99;
    std::string fine = slope("fine.tif", 50, 40, {500201, 4, 0, 3999901, 0, -4}, holed, 5);
    {
        const DatasetHandle edit(GDALDataset::Open(fine.c_str(), GDAL_OF_UPDATE));
        float hole = -99;
        for (int k = 0; k < 9; ++k) {  // around (500223, 3999879): coarse has a height there
            ASSERT_EQ(edit->GetRasterBand(1)->RasterIO(GF_Write, 4 + k % 3, 4 + k / 3, 1, 1, &hole,
                                                       1, 1, GDT_Float32, 0, 0, nullptr),
                      CE_None);
        }
    }
    const std::string far = slope("far.tif", 10, 10, {500500, 10, 0, 4e6, 0, -10});
    open({coarse, fine, far});
    EXPECT_EQ(dem_.source->info().worldFromLattice.column, Vec2(4, 0));
    EXPECT_EQ(dem_.source->info().scheme.columns, 151);  // 500 000 to 500 600, aligned to `fine`
    EXPECT_NEAR(above(500100, 3999900), 0, 1e-3);
    EXPECT_NEAR(above(500250, 3999850), 5, 1e-3);
    EXPECT_NEAR(above(500380, 3999760), 5, 1e-3);
    EXPECT_NEAR(above(500223, 3999879), 0, 1e-3);
    EXPECT_NEAR(above(500550, 3999950), 0, 1e-3);
    EXPECT_TRUE(std::isnan(above(500450, 3999950)));
    open({fine, coarse, far});
    EXPECT_NEAR(above(500250, 3999850), 0, 1e-3);
    EXPECT_NEAR(above(500380, 3999760), 5, 1e-3);
}

TEST_F(DemMosaicTest, OtherCrssAreWarpedToTheFirstOnes) {
    const std::string first = slope("first.tif", 40, 40, {5e5, 10, 0, 4e6, 0, -10});
    test::RasterRecipe recipe;
    recipe.crs = "EPSG:4326";
    const std::string degrees =
        slope("degrees.tif", 60, 50, {15.003, 1e-4, 0, 36.1444, 0, -1e-4}, recipe);
    recipe.crs = "EPSG:32632";
    const auto frame = GeoFrame::make(describeCrs(kZone33)->wkt, describeCrs("EPSG:32632")->wkt);
    const Vec2 corner = *frame->worldFromData({500100, 3999000});
    const std::string zone32 =
        slope("zone32.tif", 50, 30, {corner.x, 12, 0, corner.y, 0, -12}, recipe);
    open({first, degrees, zone32});
    EXPECT_EQ(dem_.facts.workingCrsName, "WGS 84 / UTM zone 33N");
    int heights = 0;
    const TerrainInfo& info = dem_.source->info();
    for (int64_t k = 0; k < static_cast<int64_t>(posts_.size()); ++k) {
        const float z = posts_[static_cast<size_t>(k)];
        if (std::isnan(z)) continue;
        ++heights;
        const Vec2 p =
            info.worldFromLattice.worldFromLattice({static_cast<double>(k % info.scheme.columns),
                                                    static_cast<double>(k / info.scheme.columns)});
        ASSERT_NEAR(static_cast<double>(z), plane(p), 0.25) << p.x << " " << p.y;  // rims repeat
    }
    EXPECT_GT(heights, (400 * 400 + 450 * 500 / 2 + 600 * 360) / 110);
}

TEST_F(DemMosaicTest, UnitsAndTypesMayDifferAndPostsOfOneLatticeStayAsTheyAre) {
    const std::string metres = slope("metres.tif", 20, 20, {5e5, 10, 0, 4e6, 0, -10});
    test::RasterRecipe recipe;
    recipe.type = GDT_Float64;
    recipe.unit = "ft";
    metres_ = 0.3048;
    const std::string feet = slope("feet.tif", 20, 20, {500200, 10, 0, 4e6, 0, -10}, recipe);
    open({metres, feet});
    EXPECT_EQ(dem_.source->info().scheme.columns, 40);
    EXPECT_EQ(dem_.source->info().scheme.rows, 20);
    for (const double x : {500005.0, 500195.0, 500205.0, 500395.0}) {
        EXPECT_NEAR(above(x, 3999895), 0, 2e-5) << x;
    }
}

TEST_F(DemMosaicTest, WhatCannotBeJoinedIsNamed) {
    const auto refused = [&](const std::vector<std::string>& names, const std::string& words) {
        const auto dem = openUnlikeDems(names, {});
        ASSERT_FALSE(dem.ok());
        EXPECT_NE(dem.error().message.find(words), std::string::npos) << dem.error().message;
    };
    const std::string a = slope("a.tif", 4, 3, {5e5, 10, 0, 4e6, 0, -10});
    refused({a, path("missing.tif")}, "missing.tif");
    test::RasterRecipe other;
    other.values.assign(12, 1);
    other.crs = "";
    refused({a, write(other, "bare.tif")}, "bare.tif' has no CRS");
    other.transform.reset();
    refused({a, write(other, "nowhere.tif")}, "nowhere.tif' has no georeference");
    refused({a, slope("far.tif", 4, 3, {590000, 10, 0, 4e6, 0, -10})}, "too far apart");
}

}  // namespace
}  // namespace terray
