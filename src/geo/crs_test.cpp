// SPDX-License-Identifier: Apache-2.0
// Tests of describeCrs: what is read from WKT1, WKT2, PROJJSON, codes and names.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geo/frame.h"

namespace terray {
namespace {

using testing::HasSubstr;

TEST(DescribeCrs, ReadsAGeographicCode) {
    const auto facts = describeCrs("EPSG:4326");
    ASSERT_TRUE(facts) << facts.error().message;
    EXPECT_EQ(facts->name, "WGS 84");
    EXPECT_TRUE(facts->geographic);
    EXPECT_FALSE(facts->projected);
    EXPECT_EQ(facts->unitName, "degree");
    EXPECT_DOUBLE_EQ(facts->semiMajor, 6378137);
    EXPECT_NEAR(facts->semiMinor, 6356752.314245, 1e-6);
    EXPECT_THAT(facts->wkt, HasSubstr("GEOGCRS["));
}

TEST(DescribeCrs, ReadsFeet) {
    const auto facts = describeCrs("EPSG:2264");
    ASSERT_TRUE(facts);
    EXPECT_TRUE(facts->projected);
    EXPECT_EQ(facts->unitName, "US survey foot");
    EXPECT_NEAR(facts->metresPerUnit, 1200.0 / 3937.0, 1e-15);
}

TEST(DescribeCrs, GivesTheSameFactsForEveryWriting) {
    const char* const wkt1 =
        "PROJCS[\"WGS 84 / UTM zone 33N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\","
        "SPHEROID[\"WGS 84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],"
        "UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
        "PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",15],"
        "PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\",500000],"
        "PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]";
    const auto fromCode = describeCrs("EPSG:32633");
    ASSERT_TRUE(fromCode);
    for (const std::string& text :
         {std::string(wkt1), fromCode->wkt, std::string("+proj=utm +zone=33 +datum=WGS84"),
          std::string("WGS 84 / UTM zone 33N")}) {
        const auto facts = describeCrs(text);
        ASSERT_TRUE(facts) << text;
        EXPECT_TRUE(facts->projected) << text;
        EXPECT_DOUBLE_EQ(facts->metresPerUnit, 1) << text;
        EXPECT_NEAR(facts->semiMinor, fromCode->semiMinor, 1e-6) << text;
        EXPECT_THAT(facts->wkt, HasSubstr("PROJCRS[")) << text;
    }
}

TEST(DescribeCrs, FindsTheHeightUnitOfACompoundCrs) {
    const auto feet = describeCrs("EPSG:26910+6360");  // NAVD88 height (ftUS)
    ASSERT_TRUE(feet) << feet.error().message;
    EXPECT_TRUE(feet->vertical);
    EXPECT_TRUE(feet->projected);
    EXPECT_EQ(feet->heightUnitName, "US survey foot");
    EXPECT_NEAR(feet->metresPerHeightUnit, 1200.0 / 3937.0, 1e-15);
    EXPECT_EQ(feet->unitName, "metre");
    const auto ellipsoidal = describeCrs("EPSG:4979");  // WGS 84 in 3-D
    ASSERT_TRUE(ellipsoidal);
    EXPECT_TRUE(ellipsoidal->geographic);
    EXPECT_EQ(ellipsoidal->heightUnitName, "metre");
    EXPECT_EQ(describeCrs("EPSG:26910")->heightUnitName, "");
}

TEST(DescribeCrs, KnowsOtherBodies) {
    const auto moon = describeCrs("+proj=longlat +R=1737400 +no_defs");
    ASSERT_TRUE(moon);
    EXPECT_TRUE(moon->geographic);
    EXPECT_DOUBLE_EQ(moon->semiMajor, 1737400);
    EXPECT_DOUBLE_EQ(moon->semiMinor, 1737400);
}

TEST(DescribeCrs, TakesALocalCrsAsNeitherGeographicNorProjected) {
    const auto local = describeCrs("LOCAL_CS[\"site grid\",UNIT[\"foot\",0.3048]]");
    ASSERT_TRUE(local) << local.error().message;
    EXPECT_FALSE(local->geographic);
    EXPECT_FALSE(local->projected);
    EXPECT_DOUBLE_EQ(local->metresPerUnit, 0.3048);
}

TEST(DescribeCrs, RefusesNonsenseWithOneSentence) {
    const auto unknown = describeCrs("EPSG:999999");
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, ErrorCode::Usage);
    EXPECT_THAT(unknown.error().message, HasSubstr("EPSG:999999"));
    const auto wkt = describeCrs("PROJCS[\"broken\",\n" + std::string(100000, 'x'));
    ASSERT_FALSE(wkt);
    EXPECT_EQ(wkt.error().code, ErrorCode::Input);
    EXPECT_LT(wkt.error().message.size(), 250u);
    EXPECT_EQ(wkt.error().message.find('\n'), std::string::npos);
    for (const char* name : {"foo", "UTM zone 11", "32633"}) {
        EXPECT_FALSE(describeCrs(name)) << "completed to " << describeCrs(name)->name;
    }
    EXPECT_TRUE(describeCrs("wgs 84 / UTM zone 33N"));
    for (const char* text : {"", "EPSG:", "+proj=nosuch", "{}", "[", "EPSG:5703", "EPSG:4978"}) {
        EXPECT_FALSE(describeCrs(text)) << text;
    }
}

}  // namespace
}  // namespace terray
