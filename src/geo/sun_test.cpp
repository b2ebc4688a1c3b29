// SPDX-License-Identifier: Apache-2.0
// Tests of the sun's place against published values and the geometry of the sphere, and of times.
#include "geo/sun.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "math/types.h"

namespace terray {
namespace {

using testing::HasSubstr;

double julianDay(const std::string& text) {
    const auto moment = parseIsoTime(text);
    EXPECT_TRUE(moment) << moment.error().message;
    return moment ? moment->julianDay : 0;
}

/// Declination: the elevation that the pole sees, without parallax.
double declination(double day) { return sunPosition(day, 0, 90).elevationDeg + 0.0024; }

// Reda and Andreas, Solar Position Algorithm, NREL/TP-560-34302 (2008), appendix A.5: azimuth
// 194.34024; elevation without refraction 39.872046.
TEST(SunPosition, AgreesWithNrelsExample) {
    const SunPosition sun =
        sunPosition(julianDay("2003-10-17T12:30:30-07:00"), -105.1786, 39.742476);
    EXPECT_NEAR(sun.azimuthDeg, 194.34024, 0.01);
    EXPECT_NEAR(sun.elevationDeg, 39.872046, 0.01);
}

// Meeus, Astronomical Algorithms, example 25.a (1992 October 13, 0h TD): declination -7.78507;
// example 28.a: equation of time +13m 42.6s, so the sun culminates at longitude 176.5725.
TEST(SunPosition, AgreesWithMeeusExamples) {
    const double day = 2448908.5 - 59.0 / 86400;
    EXPECT_NEAR(declination(day), -7.78507, 0.002);
    const SunPosition noon = sunPosition(2448908.5, 180 - 3.4275, 40);
    EXPECT_NEAR(noon.azimuthDeg, 180, 0.01);
    EXPECT_NEAR(noon.elevationDeg, 90 - 40 - 7.78507, 0.01);
}

// Equinoxes and solstices, UT, from Meeus' tables and the Astronomical Almanac.
TEST(SunPosition, KnowsTheSeasonsOfACentury) {
    for (const char* equinox : {"1950-03-21T04:35Z", "2000-03-20T07:35Z", "2024-03-20T03:06Z",
                                "2000-09-22T17:28Z", "2024-09-22T12:44Z", "2050-03-20T10:19Z"}) {
        EXPECT_NEAR(declination(julianDay(equinox)), 0, 0.004) << equinox;
    }
    // at a solstice the declination is the obliquity: the mean one of the year and up to 0.0026
    // degree of nutation
    for (const char* june : {"1950-06-21T23:36Z", "2024-06-20T20:51Z", "2050-06-21T03:32Z"}) {
        const double day = julianDay(june);
        const double obliquity = 23.439291 - 0.0130042 * (day - 2451545) / 36525;
        EXPECT_NEAR(declination(day), obliquity, 0.003) << june;
    }
    EXPECT_NEAR(declination(julianDay("2024-12-21T09:20Z")), -23.4362, 0.003);
}

TEST(SunPosition, HasPolarDayAndNight) {
    for (int hour = 0; hour < 24; ++hour) {
        const double june = julianDay("2024-06-21T00:00Z") + hour / 24.0;
        const double december = julianDay("2024-12-21T00:00Z") + hour / 24.0;
        EXPECT_GT(sunPosition(june, 25, 71).elevationDeg, 4);
        EXPECT_LT(sunPosition(december, 25, 71).elevationDeg, -4);
        EXPECT_LT(sunPosition(june, 25, -71).elevationDeg, -4);
        EXPECT_GT(sunPosition(december, 25, -71).elevationDeg, 4);
    }
}

TEST(SunPosition, RisesInTheEastAndCulminatesTowardsTheEquator) {
    const double noonAtGreenwich = julianDay("2024-04-15T12:00Z");  // equation of time about 0
    EXPECT_NEAR(sunPosition(noonAtGreenwich, 0, 45).azimuthDeg, 180, 0.5);
    const double south = sunPosition(noonAtGreenwich, 0, -45).azimuthDeg;
    EXPECT_NEAR(std::remainder(south, 360), 0, 0.5);
    for (const double latitude : {-45.0, 0.0, 45.0}) {
        EXPECT_LT(sunPosition(noonAtGreenwich - 0.25, 0, latitude).azimuthDeg, 180);
        EXPECT_GT(sunPosition(noonAtGreenwich + 0.25, 0, latitude).azimuthDeg, 180);
    }
}

TEST(SunPosition, ObeysTheSphereAtRandomPlacesAndTimes) {
    std::mt19937 random(42);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < 1000; ++k) {
        const double day = 2433282.5 + 36525 * unit(random);  // 1950 to 2050
        const double latitude = -89 + 178 * unit(random);
        const double noonLongitude = 180 - sunPosition(day, 0, 90).azimuthDeg;
        const double decl = declination(day);
        ASSERT_LT(std::abs(decl), 23.46);

        const SunPosition noon = sunPosition(day, noonLongitude, latitude);
        EXPECT_NEAR(noon.elevationDeg, 90 - std::abs(latitude - decl), 0.005);
        if (std::abs(latitude - decl) > 1) {
            const double meridian = latitude > decl ? 180 : 0;
            EXPECT_NEAR(std::remainder(noon.azimuthDeg - meridian, 360), 0, 1e-6);
        }
        const double apart = 180 * unit(random);  // morning and afternoon
        const SunPosition before = sunPosition(day, noonLongitude - apart, latitude);
        const SunPosition after = sunPosition(day, noonLongitude + apart, latitude);
        EXPECT_NEAR(before.elevationDeg, after.elevationDeg, 1e-6);
        EXPECT_NEAR(std::remainder(before.azimuthDeg + after.azimuthDeg, 360), 0, 1e-6);
        const double sine = std::sin(radFromDeg(latitude)) * std::sin(radFromDeg(decl)) +
                            std::cos(radFromDeg(latitude)) * std::cos(radFromDeg(decl)) *
                                std::cos(radFromDeg(apart));
        EXPECT_NEAR(after.elevationDeg, degFromRad(std::asin(sine)), 0.005);
        // at the antipode the sun stands as far below the horizon, mirrored
        const SunPosition below = sunPosition(day, noonLongitude + apart + 180, -latitude);
        EXPECT_NEAR(below.elevationDeg, -after.elevationDeg, 0.005);
        EXPECT_NEAR(std::remainder(below.azimuthDeg + after.azimuthDeg, 360), 0, 1e-6);
        EXPECT_GE(after.azimuthDeg, 0);
        EXPECT_LT(after.azimuthDeg, 360);
    }
}

TEST(IsoTime, GivesTheJulianDay) {
    EXPECT_DOUBLE_EQ(julianDay("2000-01-01T12:00:00Z"), 2451545.0);
    EXPECT_DOUBLE_EQ(julianDay("1987-01-27T00:00Z"), 2446822.5);  // Meeus, page 62
    EXPECT_DOUBLE_EQ(julianDay("1600-12-31 00:00"), 2305812.5);   // Meeus, page 62
    EXPECT_DOUBLE_EQ(julianDay("2024-02-29T18:00:00Z"), 2460370.25);
    EXPECT_NEAR(julianDay("2000-01-01T12:00:00.500Z") - 2451545.0, 0.5 / 86400, 1e-9);
}

TEST(IsoTime, AppliesOffsets) {
    const auto summer = parseIsoTime("2024-06-21T00:30:00+02:00");
    ASSERT_TRUE(summer);
    EXPECT_EQ(summer->utcText, "2024-06-20T22:30:00Z");
    EXPECT_TRUE(summer->hadOffset);
    EXPECT_DOUBLE_EQ(summer->julianDay, julianDay("2024-06-20T22:30:00Z"));
    EXPECT_EQ(parseIsoTime("2023-12-31T20:00-0545")->utcText, "2024-01-01T01:45:00Z");
    EXPECT_EQ(parseIsoTime("2024-03-01T00:00+01")->utcText, "2024-02-29T23:00:00Z");
    EXPECT_EQ(parseIsoTime("1969-12-31T23:59:59Z")->utcText, "1969-12-31T23:59:59Z");
    const auto plain = parseIsoTime("2024-06-21 12:00");
    ASSERT_TRUE(plain);
    EXPECT_FALSE(plain->hadOffset);
    EXPECT_EQ(plain->utcText, "2024-06-21T12:00:00Z");
}

TEST(IsoTime, RefusesEverythingElse) {
    for (const char* bad : {"",
                            "noon",
                            "2024",
                            "2024-06-21",
                            "2024-6-21T12:00",
                            "21.06.2024 12:00",
                            "2024-06-21T12",
                            "2024-06-21T12:00:00 Z",
                            "2024-06-21T12:00:00Zz",
                            "2024-06-21T12:00:",
                            "2024-06-21T12:00:00.",
                            "2024-06-21T12:00:00+2",
                            "2024-06-21T12:00:00+02:0",
                            "2024-06-21T12:00:00+02:60",
                            "2024-06-21T12:00:00+16:00",
                            "2024-13-01T00:00",
                            "2024-00-01T00:00",
                            "2023-02-29T00:00",
                            "1900-02-29T00:00",
                            "2024-04-31T00:00",
                            "2024-06-00T00:00",
                            "2024-06-21T24:00",
                            "2024-06-21T12:60",
                            "2024-06-21T12:00:61",
                            "-2024-06-21T12:00",
                            "1066-10-14T12:00",
                            " 2024-06-21T12:00"}) {
        const auto moment = parseIsoTime(bad);
        ASSERT_FALSE(moment) << bad;
        EXPECT_EQ(moment.error().code, ErrorCode::Usage);
        EXPECT_THAT(moment.error().message, HasSubstr("--time"));
    }
    EXPECT_TRUE(parseIsoTime("2000-02-29T00:00"));
}

}  // namespace
}  // namespace terray
