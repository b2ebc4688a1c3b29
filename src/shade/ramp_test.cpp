// SPDX-License-Identifier: Apache-2.0
// Ramps: colour text files as people write them, spread by quantiles, sea and no sea.
#include "shade/ramp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "shade/ramp_builtin.h"

namespace terray {
namespace {

std::vector<ColourStop> parsed(const std::string& text) {
    auto stops = parseColourText(text, "colours.txt", 100, 300);
    EXPECT_TRUE(stops.ok()) << (stops.ok() ? "" : stops.error().message);
    return stops.ok() ? *stops : std::vector<ColourStop>{};
}

HeightSurvey survey(const std::vector<float>& heights, int width, bool hasCrs, double cell = 30) {
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    for (float z : heights) {
        if (std::isnan(z)) continue;
        low = std::min(low, z);
        high = std::max(high, z);
    }
    return surveyHeights({heights, width, cell, low, high, hasCrs});
}

TEST(ColourText, ReadsAllThatGdalWrites) {
    const auto stops = parsed(
        "# a comment\r\n\n0 10 20 30\r\n  100,40,50,60,128\n50%\t70:80:90\n200.5 White\n"
        "nv 0 0 0 0\ndefault 1 2 3\n+1e2 brown # tail\n");
    ASSERT_EQ(stops.size(), 5u);
    EXPECT_EQ(stops[0].height, 0);
    EXPECT_EQ(stops[1].a, 128);
    EXPECT_EQ(stops[2].r, 127);       // equal heights keep the file's order
    EXPECT_EQ(stops[3].height, 200);  // 50 % of 100..300
    EXPECT_EQ(stops[3].g, 80);
    EXPECT_EQ(stops[4].b, 255);
}

TEST(ColourText, NamesFileAndLineOfNastyOnes) {
    for (const char* text :
         {"", "# nothing\n", "0 1 2\n", "0 1 2 3 4 5\n", "abc 1 2 3\n", "0 1 2 999\n", "0 -1 2 3\n",
          "0 chartreuse\n", "nan 1 2 3\n", "1e999 1 2 3\n", "% 1 2 3\n", "0 1 2 x\n", "\0\0"}) {
        const auto stops = parseColourText(text, "colours.txt", 0, 1);
        ASSERT_FALSE(stops.ok()) << text;
        EXPECT_EQ(stops.error().code, ErrorCode::Input);
        EXPECT_NE(stops.error().message.find("colours.txt"), std::string::npos);
    }
    const auto bad = parseColourText("0 1 2 3\n5 5\n", "colours.txt", 0, 1);
    ASSERT_FALSE(bad.ok());
    EXPECT_NE(bad.error().message.find("line 2"), std::string::npos);
}

TEST(ColourText, RandomBytesNeverCrash) {
    std::mt19937 random(3);
    const std::string letters = "0123456789.,-+eE% \t\n\r#nvdefault:whiteblack\xff";
    for (int run = 0; run < 2000; ++run) {
        std::string text;
        for (int k = 0; k < 60; ++k) text += letters[random() % letters.size()];
        (void)parseColourText(text, "x", 0, 1).ok();
    }
}

TEST(HeightRamp, AFileGivesItsColoursAtItsStops) {
    const auto stops = parsed("100 0 0 0\n200 100 50 200\n300 255 255 255 0\n");
    const HeightRamp ramp = HeightRamp::fromStops(stops, 100, 300);
    EXPECT_NEAR(ramp.at(200).colour.r, rules::sceneFromCode(100), 2e-3f);
    EXPECT_NEAR(ramp.at(150).colour.r, rules::sceneFromCode(50), 2e-3f);
    EXPECT_NEAR(ramp.at(300).cover, 0.0f, 1e-5f);
    EXPECT_EQ(ramp.at(-50).colour, ramp.at(100).colour);
    EXPECT_EQ(ramp.at(9000).colour, ramp.at(300).colour);
}

TEST(HeightRamp, AnUnknownNameIsAnInputErrorThatNamesIt) {
    const auto ramp = HeightRamp::make("no-such-ramp", HeightSurvey{0, 1, {0, 1}, false, false});
    ASSERT_FALSE(ramp.ok());
    EXPECT_NE(ramp.error().message.find("no-such-ramp"), std::string::npos);
}

TEST(HeightSurvey, SharesGrowFromZeroToOne) {
    std::mt19937 random(5);
    std::lognormal_distribution<float> heights(4, 1.5f);
    std::vector<float> z(200 * 200);
    for (float& v : z)
        v = random() % 7 == 0 ? std::numeric_limits<float>::quiet_NaN() : heights(random);
    const HeightSurvey s = survey(z, 200, true);
    EXPECT_EQ(s.cumulative.front(), 0.0f);
    EXPECT_NEAR(s.cumulative.back(), 1.0f, 1e-5f);
    for (size_t k = 1; k < s.cumulative.size(); ++k)
        EXPECT_GE(s.cumulative[k], s.cumulative[k - 1]);
}

TEST(HeightRamp, GreyRisesWithHeightAndFlatTerrainsWork) {
    const auto ramp = HeightRamp::make("grey", survey({1, 2, 3, 500}, 2, true));
    ASSERT_TRUE(ramp.ok());
    float last = -1;
    for (float z = 0; z <= 510; z += 5) {
        const float now = ramp->at(z).colour.g;
        EXPECT_GE(now, last);
        last = now;
    }
    for (const BuiltinRamp& builtin : builtinRamps()) {
        const auto flat =
            HeightRamp::make(std::string(builtin.name), survey({7, 7, 7, 7}, 2, true));
        ASSERT_TRUE(flat.ok());
        EXPECT_TRUE(std::isfinite(flat->at(7).colour.r + flat->at(7).rock)) << builtin.name;
    }
}

TEST(HeightRamp, SkewedHeightsStillUseMostOfTheRamp) {
    std::vector<float> z(100 * 100);
    for (size_t k = 0; k < z.size(); ++k)
        z[k] = 3000.0f * std::pow(static_cast<float>(k) / static_cast<float>(z.size()), 6.0f);
    const auto ramp = HeightRamp::make("viridis", survey(z, 100, true));
    const auto spread = HeightRamp::make("desert", survey(z, 100, true));
    ASSERT_TRUE(ramp.ok() && spread.ok());
    // The median height, 47 m of 3000, has left the linear ramp's start far behind.
    const auto away = [](const HeightRamp& r) {
        return glm::length(r.at(47).colour - r.at(0).colour);
    };
    EXPECT_LT(away(*ramp), 0.03f);
    EXPECT_GT(away(*spread), 0.10f);
}

TEST(HeightRamp, BlueOnlyWhereTheSeaPlausiblyIs) {
    const int n = 100;
    std::vector<float> coast(n * n), desert(n * n);
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const auto at = static_cast<size_t>(j * n + i);
            coast[at] = i < 30 ? 0.0f : static_cast<float>(i - 30) * 8.0f;
            desert[at] = -86.0f + static_cast<float>(i) * 30.0f + 0.37f * static_cast<float>(j % 7);
        }
    }
    const auto blue = [](const Result<HeightRamp>& ramp, float z) {
        const rules::Rgb c = ramp->at(z).colour;
        return c.b > c.r * 1.2f;
    };
    const auto natural = HeightRamp::make("", survey(coast, n, true));
    EXPECT_TRUE(blue(natural, 0) && !blue(natural, 5));
    EXPECT_FALSE(blue(HeightRamp::make("", survey(coast, n, false)), 0));
    EXPECT_FALSE(blue(HeightRamp::make("", survey(desert, n, true)), -60));
    EXPECT_TRUE(blue(HeightRamp::make("sea", survey(desert, n, true)), -60));
    coast[5] = -3000;
    EXPECT_TRUE(blue(HeightRamp::make("", survey(coast, n, true)), -1000));
}

TEST(RampTable, NamesTheBuiltinRampsTheDefaultFirst) {
    ASSERT_GE(rampTable().size(), 6u);
    EXPECT_EQ(rampTable()[0].name, "natural");
    for (const RampName& ramp : rampTable()) EXPECT_NE(findBuiltinRamp(ramp.name), nullptr);
}

}  // namespace
}  // namespace terray
