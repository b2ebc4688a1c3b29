// SPDX-License-Identifier: Apache-2.0
// Tests of chooseWorkingCrs: what stays, what is warped to which projection, what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "geo/frame.h"

namespace terray {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

Result<WorkingCrs> choose(const std::string& source, Vec2 lo, Vec2 hi,
                          const std::string& forced = "") {
    const auto facts = describeCrs(source);
    EXPECT_TRUE(facts) << facts.error().message;
    return chooseWorkingCrs(*facts, lo, hi, forced);
}

WorkingCrs chosen(const std::string& source, Vec2 lo, Vec2 hi, const std::string& forced = "") {
    const auto working = choose(source, lo, hi, forced);
    EXPECT_TRUE(working) << working.error().message;
    return working ? *working : WorkingCrs{};
}

TEST(WorkingCrs, KeepsATrueProjection) {
    for (const char* source : {"EPSG:32633", "EPSG:26710", "EPSG:2056", "EPSG:25830"}) {
        const GeoFrame frame = GeoFrame::make(source, source).value();
        const double lon = std::string(source) == "EPSG:26710"   ? -122
                           : std::string(source) == "EPSG:25830" ? -3
                           : std::string(source) == "EPSG:2056"  ? 7.5
                                                                 : 14;
        const Vec2 lo = *frame.worldFromLonLat({lon, 46}), hi = lo + Vec2(20000, 20000);
        const WorkingCrs working = chosen(source, lo, hi);
        EXPECT_TRUE(working.same) << source << ": " << working.reason;
        EXPECT_THAT(working.wkt, StartsWith("PROJCRS["));
    }
    // US survey feet: a state plane
    const WorkingCrs feet = chosen("EPSG:2264", {1400000, 500000}, {1500000, 600000});
    EXPECT_TRUE(feet.same) << feet.reason;
}

TEST(WorkingCrs, WarpsDegreesToTheUtmZoneOfTheMiddle) {
    const WorkingCrs fuji = chosen("EPSG:4326", {138, 35}, {139, 36});
    EXPECT_FALSE(fuji.same);
    EXPECT_EQ(fuji.name, "WGS 84 / UTM zone 54N");
    EXPECT_THAT(fuji.wkt, HasSubstr("ID[\"EPSG\",32654]"));
    EXPECT_THAT(fuji.reason, HasSubstr("UTM zone 54N"));
    EXPECT_EQ(chosen("EPSG:4326", {-70, -34}, {-69, -33}).name, "WGS 84 / UTM zone 19S");
    EXPECT_EQ(chosen("EPSG:4326", {-114, 34}, {-108, 39}).name, "WGS 84 / UTM zone 12N");
}

TEST(WorkingCrs, StaysOnTheSourcesDatum) {
    EXPECT_EQ(chosen("EPSG:4267", {-122, 46}, {-121, 47}).name, "NAD27 / UTM zone 10N");
    const WorkingCrs nad83 = chosen("EPSG:4269", {-122, 46}, {-121, 47});
    EXPECT_EQ(nad83.name, "NAD83 / UTM zone 10N");
    EXPECT_THAT(nad83.wkt, HasSubstr("26910"));
    // a datum that only its own shift ties to WGS 84 keeps that shift
    const WorkingCrs shifted =
        chosen("+proj=longlat +ellps=bessel +towgs84=500,100,400,0,0,0,0", {10, 50}, {11, 51});
    EXPECT_THAT(shifted.wkt, StartsWith("BOUNDCRS["));
}

TEST(WorkingCrs, TakesTheHorizontalPartOfACompoundCrs) {
    const WorkingCrs working = chosen("EPSG:26910+5703", {550000, 5100000}, {560000, 5110000});
    EXPECT_TRUE(working.same);
    EXPECT_THAT(working.wkt, StartsWith("PROJCRS["));
}

TEST(WorkingCrs, WarpsWebMercator) {
    const double r = 6378137;
    const auto north = [&](double lat) {
        return r * std::log(std::tan(kPi / 4 + radFromDeg(lat) / 2));
    };
    const Vec2 lo{r * radFromDeg(7.0), north(46)}, hi{r * radFromDeg(7.5), north(46.5)};
    const WorkingCrs alps = chosen("EPSG:3857", lo, hi);
    EXPECT_FALSE(alps.same);
    EXPECT_EQ(alps.name, "WGS 84 / UTM zone 32N");
    EXPECT_THAT(alps.reason, HasSubstr("45 %"));
    EXPECT_THAT(alps.reason, HasSubstr("46.50"));
    // at the equator the sphere of web Mercator still makes meridians 0.67 % too long
    const WorkingCrs equator = chosen("EPSG:3857", {4e6, -1000}, {4.001e6, 1000});
    EXPECT_FALSE(equator.same);
    EXPECT_THAT(equator.reason, HasSubstr("0.67 %"));
}

TEST(WorkingCrs, GoesFromUtmToLaeaToRefusalWithWidth) {
    EXPECT_THAT(chosen("EPSG:4326", {9, 44}, {15, 50}).name, HasSubstr("UTM zone 33N"));
    EXPECT_EQ(chosen("EPSG:4326", {9, 44}, {16, 50}).name, "WGS 84 / LAEA 47 12.5");
    EXPECT_THAT(chosen("EPSG:4326", {-20, -20}, {20, 20}).name, HasSubstr("LAEA 0 0"));
    for (const auto& [lo, hi] :
         {std::pair{Vec2(-20.5, 0), Vec2(20.5, 10)}, std::pair{Vec2(0, -30), Vec2(5, 30)},
          std::pair{Vec2(-180, -90), Vec2(180, 90)}}) {
        const auto refused = choose("EPSG:4326", lo, hi);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::Input);
        EXPECT_THAT(refused.error().message, HasSubstr("cut a window"));
    }
}

TEST(WorkingCrs, HandlesTheAntimeridianAndLongitudesTo360) {
    EXPECT_EQ(chosen("EPSG:4326", {179, -18}, {181.5, -16}).name, "WGS 84 / UTM zone 1S");
    EXPECT_EQ(chosen("EPSG:4326", {-181, -18}, {-179.5, -16}).name, "WGS 84 / UTM zone 60S");
    EXPECT_EQ(chosen("EPSG:4326", {237, 46}, {239, 47}).name, "WGS 84 / UTM zone 10N");
    EXPECT_EQ(chosen("EPSG:4326", {354, 40}, {360, 44}).name, "WGS 84 / UTM zone 30N");
    // web Mercator beyond 180 degrees east
    const WorkingCrs fiji = chosen("EPSG:3857", {19.95e6, -2e6}, {20.2e6, -1.8e6});
    EXPECT_FALSE(fiji.same);
    EXPECT_THAT(fiji.name, HasSubstr("UTM zone"));
}

TEST(WorkingCrs, UsesAPolarProjectionAtThePoles) {
    EXPECT_THAT(chosen("EPSG:4326", {-180, 80}, {180, 90}).name,
                HasSubstr("Stereographic North 0"));
    EXPECT_THAT(chosen("EPSG:4326", {20, -88}, {30, -85}).name,
                HasSubstr("Stereographic South 25"));
    EXPECT_THAT(chosen("EPSG:4326", {20, 60}, {30, 86}).name, HasSubstr("LAEA"));
    // an Antarctic grid is true where its scale is
    EXPECT_TRUE(chosen("EPSG:3031", {2.07e6, -2e4}, {2.1e6, 2e4}).same);
    EXPECT_FALSE(chosen("EPSG:3031", {-1e5, -1e5}, {1e5, 1e5}).same);
    EXPECT_THAT(chosen("EPSG:3031", {-1e5, -1e5}, {1e5, 1e5}).name, HasSubstr("Polar"));
}

TEST(WorkingCrs, UsesTheBodysOwnEllipsoid) {
    const WorkingCrs moon = chosen("+proj=longlat +R=1737400 +no_defs", {10, 5}, {12, 7});
    EXPECT_THAT(moon.name, HasSubstr("Transverse Mercator 11"));
    const auto facts = describeCrs(moon.wkt);
    ASSERT_TRUE(facts);
    EXPECT_DOUBLE_EQ(facts->semiMajor, 1737400);
    // equirectangular Mars at 45 degrees north
    const WorkingCrs mars = chosen("+proj=eqc +R=3396190 +units=m", {0, 2.6e6}, {1e5, 2.7e6});
    EXPECT_FALSE(mars.same);
    EXPECT_DOUBLE_EQ(describeCrs(mars.wkt)->semiMajor, 3396190);
}

TEST(WorkingCrs, ObeysCrs) {
    const WorkingCrs forced = chosen("EPSG:4326", {7, 46}, {8, 47}, "EPSG:2056");
    EXPECT_FALSE(forced.same);
    EXPECT_EQ(forced.name, "CH1903+ / LV95");
    EXPECT_THAT(forced.reason, HasSubstr("--crs"));
    EXPECT_TRUE(chosen("EPSG:32632", {4e5, 5e6}, {5e5, 5.1e6}, "EPSG:32632").same);
    for (const char* bad : {"EPSG:4326", "EPSG:4978", "nonsense", "EPSG:5703"}) {
        const auto refused = choose("EPSG:4326", {7, 46}, {8, 47}, bad);
        ASSERT_FALSE(refused) << bad;
        EXPECT_EQ(refused.error().code, ErrorCode::Usage) << bad;
        EXPECT_THAT(refused.error().message, HasSubstr("--crs")) << bad;
    }
}

TEST(WorkingCrs, RefusesCoordinatesThatCannotBeDegrees) {
    for (const auto& [lo, hi] :
         {std::pair{Vec2(5e5, 4e6), Vec2(6e5, 4.1e6)}, std::pair{Vec2(0, 95), Vec2(1, 97)},
          std::pair{Vec2(600, 45), Vec2(601, 46)}}) {
        const auto refused = choose("EPSG:4326", lo, hi);
        ASSERT_FALSE(refused);
        EXPECT_EQ(refused.error().code, ErrorCode::Input);
        EXPECT_THAT(refused.error().message, HasSubstr("--assign-crs"));
    }
}

TEST(WorkingCrs, NeverWorksInACrsThatRunsWest) {
    const WorkingCrs cape = chosen("EPSG:2053", {-50000, 3.4e6}, {50000, 3.5e6});
    EXPECT_FALSE(cape.same);
    EXPECT_THAT(cape.reason, HasSubstr("west"));
}

TEST(WorkingCrs, KeepsLocalCoordinates) {
    const WorkingCrs local =
        chosen("LOCAL_CS[\"site grid\",UNIT[\"metre\",1]]", {0, 0}, {100, 100});
    EXPECT_TRUE(local.same);
}

}  // namespace
}  // namespace terray
