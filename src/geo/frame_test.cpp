// SPDX-License-Identifier: Apache-2.0
// Tests of GeoFrame: maps against published values, round trips, convergence and curvature.
#include "geo/frame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace terray {
namespace {

GeoFrame makeFrame(const std::string& data, const std::string& working) {
    auto frame = GeoFrame::make(data, working);
    EXPECT_TRUE(frame) << frame.error().message;
    return std::move(frame).value();
}

void expectNear(const Result<Vec2>& found, Vec2 wanted, double tolerance) {
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NEAR(found->x, wanted.x, tolerance);
    EXPECT_NEAR(found->y, wanted.y, tolerance);
}

TEST(GeoFrame, IsTheIdentityWithoutACrs) {
    const GeoFrame frame = makeFrame("", "");
    EXPECT_FALSE(frame.hasCrs());
    expectNear(frame.worldFromData({3, 4}), {3, 4}, 0);
    expectNear(frame.dataFromWorld({3, 4}), {3, 4}, 0);
    EXPECT_EQ(frame.curvatureRadius({3, 4}), 0);
    const auto place = frame.worldFromLonLat({3, 4});
    ASSERT_FALSE(place);
    EXPECT_EQ(place.error().code, ErrorCode::Usage);
    EXPECT_FALSE(frame.meridianConvergence({3, 4}));
}

// Snyder, Map Projections: A Working Manual (1987), p. 269: 40.5 N, 73.5 W, Clarke 1866.
TEST(GeoFrame, AgreesWithSnydersTransverseMercator) {
    const GeoFrame frame = makeFrame("EPSG:4267", "EPSG:26718");
    expectNear(frame.worldFromData({-73.5, 40.5}), {627106.5, 4484124.4}, 0.1);
    expectNear(frame.dataFromWorld({627106.5, 4484124.4}), {-73.5, 40.5}, 1e-6);
    expectNear(frame.lonLatFromWorld({627106.5, 4484124.4}), {-73.5, 40.5}, 1e-6);
}

TEST(GeoFrame, CountsWorldInMetresWhenTheCrsCountsFeet) {
    const GeoFrame frame = makeFrame("EPSG:2264", "EPSG:2264");
    const double foot = 1200.0 / 3937.0;
    expectNear(frame.worldFromData({2000000, 600000}), {2000000 * foot, 600000 * foot}, 1e-6);
    const GeoFrame metres = makeFrame("EPSG:4269", "EPSG:32119");  // the same zone in metres
    const Vec2 inFeet = *frame.worldFromLonLat({-80, 35.5});
    expectNear(metres.worldFromLonLat({-80, 35.5}), inFeet, 1e-3);
}

TEST(GeoFrame, RoundTripsReturn) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    const GeoFrame frame = makeFrame("EPSG:3857", "EPSG:32633");
    for (int k = 0; k < 200; ++k) {
        const Vec2 lonLat{10 + 10 * unit(random), -70 + 140 * unit(random)};
        const Result<Vec2> world = frame.worldFromLonLat(lonLat);
        ASSERT_TRUE(world);
        expectNear(frame.lonLatFromWorld(*world), lonLat, 1e-9);
        const Result<Vec2> data = frame.dataFromWorld(*world);
        ASSERT_TRUE(data);
        expectNear(frame.worldFromData(*data), *world, 1e-5);
    }
}

TEST(GeoFrame, WrapsLongitudesAroundTheDatasMiddle) {
    GeoFrame frame = makeFrame("EPSG:4326", "EPSG:32601");  // central meridian 177 W
    const Vec2 world = *frame.worldFromData({181, 50});
    expectNear(frame.worldFromData({-179, 50}), world, 1e-6);
    frame.wrapDataLongitudes(180);
    expectNear(frame.dataFromWorld(world), {181, 50}, 1e-9);
    expectNear(frame.lonLatFromWorld(world), {-179, 50}, 1e-9);
    frame.wrapDataLongitudes(-180);
    expectNear(frame.dataFromWorld(world), {-179, 50}, 1e-9);
}

// NTF (Paris): grads from the meridian of Paris, 2 deg 20' 14.025" east of Greenwich.
TEST(GeoFrame, GivesDegreesFromGreenwichForGradsFromParis) {
    const GeoFrame frame = makeFrame("EPSG:4807", "EPSG:27572");
    const Vec2 world = *frame.worldFromData({1, 50});
    expectNear(frame.lonLatFromWorld(world), {2.33722917 + 0.9, 45}, 1e-7);
    expectNear(frame.worldFromLonLat({2.33722917 + 0.9, 45}), world, 0.02);
}

// Convergence series of the transverse Mercator: Snyder, eq. (8-15) in powers of the longitude.
double utmConvergence(double lonFromMeridianDeg, double latDeg) {
    const double l = radFromDeg(lonFromMeridianDeg), phi = radFromDeg(latDeg);
    const double eta2 = 0.00673949674228 * std::cos(phi) * std::cos(phi);
    const double c2 = std::cos(phi) * std::cos(phi), t2 = std::tan(phi) * std::tan(phi);
    return l * std::sin(phi) *
           (1 + l * l * c2 / 3 * (1 + 3 * eta2 + 2 * eta2 * eta2) +
            l * l * l * l * c2 * c2 / 15 * (2 - t2));
}

TEST(GeoFrame, ConvergenceIsPositiveEastOfTheMeridianInTheNorth) {
    const GeoFrame north = makeFrame("EPSG:32633", "EPSG:32633");  // meridian 15 E
    const GeoFrame south = makeFrame("EPSG:32733", "EPSG:32733");
    for (const double lon : {-3.0, -1.0, 0.0, 2.0, 3.0}) {
        for (const double lat : {5.0, 45.0, 70.0, 83.0}) {
            const Vec2 up = *north.worldFromLonLat({15 + lon, lat});
            EXPECT_NEAR(*north.meridianConvergence(up), utmConvergence(lon, lat), 2e-8);
            const Vec2 down = *south.worldFromLonLat({15 + lon, -lat});
            EXPECT_NEAR(*south.meridianConvergence(down), utmConvergence(lon, -lat), 2e-8);
        }
    }
}

// azimuth from true north = grid heading + convergence, with a step along a parallel as the witness
TEST(GeoFrame, ConvergenceTurnsGridHeadingsIntoAzimuths) {
    const GeoFrame frame = makeFrame("EPSG:3413", "EPSG:3413");  // polar stereographic
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < 100; ++k) {
        const Vec2 place{-180 + 360 * unit(random), 60 + 29 * unit(random)};
        const Vec2 here = *frame.worldFromLonLat(place);
        const Vec2 east = *frame.worldFromLonLat({place.x + 1e-4, place.y}) - here;
        const double heading = std::atan2(east.x, east.y);
        const double azimuth = heading + *frame.meridianConvergence(here);
        EXPECT_NEAR(std::remainder(azimuth - kPi / 2, 2 * kPi), 0, 1e-5);
    }
}

TEST(GeoFrame, CurvatureRadiusIsTheGaussianMean) {
    const GeoFrame frame = makeFrame("EPSG:4326", "EPSG:32631");
    EXPECT_NEAR(frame.curvatureRadius(*frame.worldFromLonLat({3, 0})), 6356752.314, 0.01);
    EXPECT_NEAR(frame.curvatureRadius(*frame.worldFromLonLat({3, 45})), 6378101.03, 0.1);
    const GeoFrame pole = makeFrame("EPSG:5041", "EPSG:5041");
    EXPECT_NEAR(pole.curvatureRadius(*pole.worldFromLonLat({0, 90})), 6399593.626, 0.01);
    const GeoFrame moon = makeFrame("+proj=longlat +R=1737400", "+proj=tmerc +lon_0=3 +R=1737400");
    EXPECT_NEAR(moon.curvatureRadius(*moon.worldFromLonLat({3, 20})), 1737400, 1e-3);
}

TEST(GeoFrame, MapsLocalCoordinatesByTheirUnitOnly) {
    const std::string local = "LOCAL_CS[\"site grid\",UNIT[\"foot\",0.3048]]";
    const GeoFrame frame = makeFrame(local, local);
    EXPECT_FALSE(frame.hasCrs());
    expectNear(frame.worldFromData({1000, 10}), {304.8, 3.048}, 1e-9);
}

TEST(GeoFrame, RefusesDegreesAsWorkingCrsAndPlacesOutsideTheDomain) {
    const auto degrees = GeoFrame::make("EPSG:4326", "EPSG:4326");
    ASSERT_FALSE(degrees);
    EXPECT_EQ(degrees.error().code, ErrorCode::Usage);
    EXPECT_FALSE(GeoFrame::make("nonsense", "EPSG:32633"));
    const GeoFrame frame = makeFrame("EPSG:4326", "EPSG:32633");
    const auto outside = frame.worldFromData({15, 200});
    ASSERT_FALSE(outside);
    EXPECT_EQ(outside.error().code, ErrorCode::Input);
}

}  // namespace
}  // namespace terray
