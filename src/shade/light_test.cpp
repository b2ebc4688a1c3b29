// SPDX-License-Identifier: Apache-2.0
// Light, air and display: balance, readable shadows, a shoulder that never clips.
#include "shade/light.h"

#include <gtest/gtest.h>

#include "shade/background.h"
#include "shade/display.h"
#include "shade/rules/air.h"
#include "shade/rules/lines.h"

namespace terray {
namespace {

Sun sunAt(double elevationDeg) {
    const double e = radFromDeg(elevationDeg);
    return {{-std::cos(e) * 0.6, std::cos(e) * 0.8, std::sin(e)}, {0, 0}, elevationDeg < 0};
}

TEST(Light, LevelGroundUnderTheDefaultSunReceivesOneFourFifthsFromTheSun) {
    const rules::Light light = makeLight(sunAt(40));
    const float facing = static_cast<float>(std::sin(radFromDeg(40)));
    const float all = rules::luminance(rules::lightOn(light, facing, 1, 1, 1));
    const float shadow = rules::luminance(rules::lightOn(light, facing, 0, 1, 1));
    EXPECT_NEAR(all, 1.0f, 0.02f);
    EXPECT_GT((all - shadow) / shadow, 3.5f);
    EXPECT_LT((all - shadow) / shadow, 5.0f);
}

TEST(Light, SunIsWarmShadowIsCool) {
    const rules::Light light = makeLight(sunAt(40));
    EXPECT_GT(light.sun.r, light.sun.b);
    const rules::Rgb shadow = rules::lightOn(light, 0, 0, 1, 1);
    EXPECT_GT(shadow.b, shadow.r);
    EXPECT_GT(makeLight(sunAt(4)).sun.r / makeLight(sunAt(4)).sun.b, light.sun.r / light.sun.b);
}

TEST(Light, IsReadableWithTheSunBelowTheHorizon) {
    const rules::Light light = makeLight(sunAt(-12));
    EXPECT_EQ(light.sun.g, 0.0f);
    EXPECT_GT(rules::luminance(rules::lightOn(light, 0, 0, 1, 1)), 0.25f);
}

TEST(Light, OpenPlacesAreBrighterThanHollows) {
    const rules::Light light = makeLight(sunAt(40));
    float last = -1;
    for (float open = 0; open <= 1.0f; open += 0.1f) {
        const float now = rules::luminance(rules::lightOn(light, 0.6f, 1, open, 0.9f));
        EXPECT_GT(now, last);
        last = now;
    }
}

TEST(Shoulder, RisesNeverClipsAndIsUndoneByItsInverse) {
    float last = -1;
    for (float v = 0; v < 3.0f; v += 0.01f) {
        const float shown = rules::displayFromScene(v);
        EXPECT_GT(shown, last);
        EXPECT_LE(shown, 1.0f);
        last = shown;
    }
    for (float shown = 0; shown < 0.99f; shown += 0.01f)
        EXPECT_NEAR(rules::displayFromScene(rules::sceneFromDisplay(shown)), shown, 1e-5f);
}

TEST(DisplayCurve, EveryCodeComesBackAndAlphaIsStraight) {
    const DisplayCurve lit(true), plain(false);
    for (int code = 0; code < 256; ++code) {
        const float share = 0.5f, scene = rules::sceneFromCode(static_cast<float>(code)) * share;
        const float flat = rules::linearFromSrgb(static_cast<float>(code) / 255.0f);
        const Colour in[2] = {{scene, scene, scene, share}, {flat, flat, flat, 1}};
        uint8_t out[8];
        lit.apply({in, 1}, {out, 4});
        plain.apply({in + 1, 1}, {out + 4, 4});
        EXPECT_NEAR(out[0], code, code < 12 ? 1 : 0) << code;
        EXPECT_EQ(out[3], 128);
        EXPECT_NEAR(out[4], code, code < 12 ? 1 : 0) << code;
    }
    const Colour nothing{};
    uint8_t out[4] = {9, 9, 9, 9};
    lit.apply({&nothing, 1}, out);
    EXPECT_EQ(out[3], 0);
}

TEST(Air, HazeGrowsWithDistanceToTheHorizonColour) {
    rules::Air air;
    air.extinction = 1e-4f;
    air.start = 1000;
    const rules::Rgb ground{0.1f, 0.2f, 0.05f};
    EXPECT_EQ(rules::throughAir(air, ground, 900), ground);
    const rules::Rgb far = rules::throughAir(air, ground, 1e6f);
    EXPECT_NEAR(far.g, air.horizon.g, 1e-4f);
    EXPECT_NEAR(rules::clearness(air, 1000 + 10986), 1.0f / 3, 1e-3f);
}

TEST(Background, ReadsItsThreeFormsAndRefusesOthers) {
    EXPECT_EQ(parseBackground("sky")->kind, Background::Kind::Sky);
    EXPECT_EQ(parseBackground("transparent")->kind, Background::Kind::Transparent);
    const auto white = parseBackground("#FFffff");
    ASSERT_TRUE(white.ok());
    const DisplayCurve curve(true);
    const Colour c{white->colour.r, white->colour.g, white->colour.b, 1};
    uint8_t out[4];
    curve.apply({&c, 1}, out);
    EXPECT_EQ(out[0], 255);
    for (const char* bad : {"#fff", "red", "#12345g", "#1234567", "# 12345", "Sky"}) {
        ASSERT_FALSE(parseBackground(bad).ok()) << bad;
        EXPECT_EQ(parseBackground(bad).error().code, ErrorCode::Usage);
    }
}

TEST(Contours, AreOnePixelWideAndFadeWhereTheyWouldBeDense) {
    EXPECT_GT(rules::contourCover(120, 1, 20), 0.3f);
    EXPECT_EQ(rules::contourCover(130, 1, 20), 0.0f);
    EXPECT_GT(rules::contourCover(100, 1, 20), rules::contourCover(120, 1, 20));  // index line
    EXPECT_EQ(rules::contourCover(120, 60, 20), 0.0f);  // three lines a pixel
    EXPECT_EQ(rules::contourCover(120, 0, 20), 0.0f);   // a level lake at a line's height
}

}  // namespace
}  // namespace terray
