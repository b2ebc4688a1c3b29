// SPDX-License-Identifier: Apache-2.0
// Tests of where posts lie: geotransforms of all kinds, pixel-is-point, units, missing CRSs.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "raster/raster_header.h"
#include "raster/test_rasters.h"

namespace terray {
namespace {

using test::RasterRecipe;
using test::textsOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class DemCrsTest : public test::RasterTest {
protected:
    static Vec2 worldOf(const Dem& dem, double i, double j) {
        return dem.source->info().worldFromLattice.worldFromLattice({i, j});
    }
};

void expectPlace(Vec2 place, double x, double y, double slack = 1e-6) {
    EXPECT_NEAR(place.x, x, slack);
    EXPECT_NEAR(place.y, y, slack);
}

TEST_F(DemCrsTest, PostsAreTheSamplesAtPixelCentresUnwarped) {
    RasterRecipe recipe{.columns = 3, .rows = 2, .values = {1, 2, 3, 4, 5, 6}};
    recipe.transform = {5e5, 10, 0, 4e6, 0, -20};
    const Dem dem = open(write(recipe));
    EXPECT_FALSE(dem.facts.warped);
    expectPlace(worldOf(dem, 0, 0), 5e5 + 5, 4e6 - 10);
    expectPlace(worldOf(dem, 2, 1), 5e5 + 25, 4e6 - 30);
    EXPECT_THAT(posts(dem), ElementsAre(1, 2, 3, 4, 5, 6));
    EXPECT_EQ(dem.facts.workingCrsName, dem.facts.crsName);
    EXPECT_THAT(dem.facts.geoTransform, ElementsAre(5e5, 10, 0, 4e6, 0, -20));
    EXPECT_NEAR(dem.source->info().ellipsoidRadius, 6.37e6, 2e4);
}

TEST_F(DemCrsTest, PixelIsPointLiesHalfAPixelFromPixelIsArea) {
    // both files carry the tie point (0, 0) -> (500000, 4000000)
    RasterRecipe area{.columns = 3, .rows = 2};
    const Dem inArea = open(write(area, "area.tif"));
    RasterRecipe point = area;
    point.transform = {5e5 - 5, 10, 0, 4e6 + 5, 0, -10};
    point.finish = [](GDALDataset& dataset) { dataset.SetMetadataItem("AREA_OR_POINT", "Point"); };
    const std::string file = write(point, "point.tif");
    const Dem atPoint = open(file);
    EXPECT_TRUE(atPoint.facts.pixelIsPoint);
    EXPECT_FALSE(inArea.facts.pixelIsPoint);
    expectPlace(worldOf(inArea, 0, 0), 5e5 + 5, 4e6 - 5);
    expectPlace(worldOf(atPoint, 0, 0), 5e5, 4e6);

    CPLSetThreadLocalConfigOption("GTIFF_POINT_GEO_IGNORE", "YES");  // shows the stored tie point
    const Result<OpenedRaster> raw = openRaster(file);
    std::array<double, 6> stored{};
    ASSERT_EQ(raw->dataset->GetGeoTransform(stored.data()), CE_None);
    CPLSetThreadLocalConfigOption("GTIFF_POINT_GEO_IGNORE", nullptr);
    EXPECT_EQ(stored[0], 5e5);
    EXPECT_EQ(stored[3], 4e6);
}

TEST_F(DemCrsTest, SouthUpMirroredAndRotatedRastersKeepTheirSamples) {
    const std::array<double, 6> transforms[] = {
        {5e5, 10, 0, 4e6, 0, 10},    // south up
        {5e5, -10, 0, 4e6, 0, -10},  // mirrored
        {5e5, 8, 6, 4e6, 6, -8},     // rotated
        {5e5, 8, 1, 4e6, 3, -20},    // sheared, not square
    };
    for (const std::array<double, 6>& t : transforms) {
        RasterRecipe recipe{.columns = 3, .rows = 2, .values = {1, 2, 3, 4, 5, 6}};
        recipe.transform = t;
        const Dem dem = open(write(recipe));
        EXPECT_FALSE(dem.facts.warped);
        EXPECT_THAT(posts(dem), ElementsAre(1, 2, 3, 4, 5, 6));
        expectPlace(worldOf(dem, 2, 1), t[0] + 2.5 * t[1] + 1.5 * t[2],
                    t[3] + 2.5 * t[4] + 1.5 * t[5]);
        EXPECT_NEAR(dem.facts.pixelWidth, std::hypot(t[1], t[4]), 1e-9);
        EXPECT_NEAR(dem.facts.pixelHeight, std::hypot(t[2], t[5]), 1e-9);
    }
}

TEST_F(DemCrsTest, SixteenBitPngWithWorldFile) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .type = GDT_UInt16, .values = {1, 2, 3, 40000}};
    recipe.driver = "PNG";
    recipe.transform.reset();
    recipe.crs.clear();
    const std::string file = write(recipe, "dem.png");
    std::ofstream(path("dem.pgw")) << "25\n0\n0\n-25\n600012.5\n5000012.5\n";
    const Dem dem = open(file);
    expectPlace(worldOf(dem, 0, 0), 600012.5, 5000012.5);
    expectPlace(worldOf(dem, 1, 1), 600037.5, 4999987.5);
    EXPECT_THAT(posts(dem), ElementsAre(1, 2, 3, 40000));
    EXPECT_THAT(textsOf(dem.facts), Contains(HasSubstr("taken as metres")));
    EXPECT_EQ(dem.source->info().ellipsoidRadius, 0);
}

TEST_F(DemCrsTest, WithoutGeoreferencePixelsAreMetres) {
    RasterRecipe recipe{.columns = 4, .rows = 3};
    recipe.transform.reset();
    recipe.crs.clear();
    const Dem dem = open(write(recipe));
    EXPECT_THAT(dem.facts.geoTransform, IsEmpty());
    EXPECT_THAT(textsOf(dem.facts), Contains(HasSubstr("no georeference")));
    expectPlace(worldOf(dem, 0, 0), 0.5, 2.5);
    expectPlace(worldOf(dem, 3, 2), 3.5, 0.5);
    EXPECT_EQ(dem.dataCrsWkt, "");
}

TEST_F(DemCrsTest, ControlPointsOnAPlaneMapAreUsedOthersAreIgnoredAndSaid) {
    for (const double bend : {0.0, 30.0}) {
        RasterRecipe recipe{.columns = 10, .rows = 10};
        recipe.transform.reset();
        recipe.crs.clear();
        recipe.finish = [bend](GDALDataset& dataset) {
            std::vector<GDAL_GCP> points(5);
            GDALInitGCPs(5, points.data());
            const double corner[5][2] = {{0, 0}, {10, 0}, {0, 10}, {10, 10}, {5, 5}};
            for (size_t k = 0; k < 5; ++k) {
                points[k].dfGCPPixel = corner[k][0];
                points[k].dfGCPLine = corner[k][1];
                points[k].dfGCPX = 5e5 + 10 * corner[k][0];
                points[k].dfGCPY = 4e6 - 10 * corner[k][1] + (k == 4 ? bend : 0);
            }
            OGRSpatialReference reference;
            reference.importFromEPSG(32633);
            ASSERT_EQ(dataset.SetGCPs(5, points.data(), &reference), CE_None);
            GDALDeinitGCPs(5, points.data());
        };
        const Dem dem = open(write(recipe));
        if (bend == 0) {
            expectPlace(worldOf(dem, 0, 0), 5e5 + 5, 4e6 - 5, 0.01);
            EXPECT_EQ(dem.facts.crsName, "WGS 84 / UTM zone 33N");
        } else {
            expectPlace(worldOf(dem, 0, 0), 0.5, 9.5);
            EXPECT_THAT(textsOf(dem.facts), Contains(HasSubstr("gdalwarp")));
        }
    }
}

TEST_F(DemCrsTest, DegreesWithoutCrsAreRefusedUntilOneIsAssigned) {
    RasterRecipe recipe{.columns = 40, .rows = 30};
    recipe.transform = {10, 0.001, 0, 47, 0, -0.001};
    recipe.crs.clear();
    const std::string file = write(recipe);
    const Error error = failure(file);
    EXPECT_EQ(error.code, ErrorCode::Input);
    EXPECT_THAT(error.message, HasSubstr("--assign-crs EPSG:4326"));
    OpenOptions options;
    options.assignCrs = "EPSG:4326";
    const Dem dem = open(file, options);
    EXPECT_TRUE(dem.facts.warped);
    EXPECT_EQ(dem.facts.crsName, "WGS 84");
    EXPECT_EQ(dem.facts.horizontalUnit, "degree");
    EXPECT_EQ(dem.facts.workingCrsName, "WGS 84 / UTM zone 32N");
}

TEST_F(DemCrsTest, ProjectedCoordinatesWithoutCrsAreMetresAndThatIsSaid) {
    RasterRecipe recipe{.columns = 4, .rows = 3};
    recipe.crs.clear();
    const std::string file = write(recipe);
    const Dem dem = open(file);
    EXPECT_THAT(textsOf(dem.facts), Contains(HasSubstr("no CRS")));
    for (const Assumption& assumption : dem.facts.assumptions)
        EXPECT_EQ(assumption.isWarning, assumption.text.find("no CRS") != std::string::npos);
    EXPECT_EQ(dem.source->info().crsWkt, "");
    OpenOptions options;
    options.workingCrs = "EPSG:32633";
    const Error error = failure(file, options);
    EXPECT_EQ(error.code, ErrorCode::Usage);
    EXPECT_THAT(error.message, HasSubstr("--assign-crs"));
}

TEST_F(DemCrsTest, AnUnknownAssignedCrsIsWrongUsage) {
    OpenOptions options;
    options.assignCrs = "EPSG:999999";
    const Error error = failure(write({}), options);
    EXPECT_EQ(error.code, ErrorCode::Usage);
    EXPECT_THAT(error.message, HasSubstr("--assign-crs EPSG:999999"));
}

TEST_F(DemCrsTest, HorizontalFeetBecomeMetres) {
    RasterRecipe recipe{.columns = 3, .rows = 2};
    recipe.crs = "EPSG:2227";  // NAD83 / California zone 3 (ftUS)
    recipe.transform = {6000000, 10, 0, 2100000, 0, -10};
    const Dem dem = open(write(recipe));
    constexpr double kFoot = 1200.0 / 3937;
    EXPECT_FALSE(dem.facts.warped);
    EXPECT_EQ(dem.facts.horizontalUnit, "US survey foot");
    EXPECT_NEAR(dem.source->info().metresPerCrsUnit, kFoot, 1e-15);
    expectPlace(worldOf(dem, 0, 0), 6000005 * kFoot, 2099995 * kFoot);
    EXPECT_NEAR(dem.facts.workingCellX, 10 * kFoot, 1e-9);
}

TEST_F(DemCrsTest, TheVerticalCrsTellsTheHeightUnit) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .values = {0, 1000, 2000, 3937}};
    recipe.crs = "EPSG:26910+6360";  // UTM 10N with NAVD88 height (ftUS)
    recipe.transform = {5e5, 10, 0, 5e6, 0, -10};
    const Dem dem = open(write(recipe));
    EXPECT_EQ(dem.facts.heightUnit, "us-ft");
    EXPECT_FALSE(dem.facts.warped);
    EXPECT_THAT(textsOf(dem.facts), IsEmpty());
    EXPECT_NEAR(posts(dem)[3], 1200, 1e-3);
}

TEST_F(DemCrsTest, TrinidadOfNcargNeedsBothFlags) {
    const std::string file = "/usr/share/ncarg/data/cdf/trinidad.nc";
    EXPECT_THAT(failure(file).message, HasSubstr("--assign-crs"));
    OpenOptions options;
    options.assignCrs = "EPSG:4326";
    options.heightUnit = HeightUnit::Foot;
    const SourceInfo facts = scanned(file, options);
    EXPECT_EQ(facts.columns, 2401);
    EXPECT_EQ(facts.rows, 1201);
    EXPECT_EQ(facts.holes, 0);
    EXPECT_NEAR(facts.minHeight, 4457 * 0.3048, 0.2);
    EXPECT_NEAR(facts.maxHeight, 14176 * 0.3048, 0.2);
    EXPECT_EQ(facts.workingCrsName, "WGS 84 / UTM zone 13N");
}

}  // namespace
}  // namespace terray
