// SPDX-License-Identifier: Apache-2.0
// Tests of legends, scale bars and north arrows.
#include "shade/annotate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "shade/legend_scale.h"
#include "shade/modes.h"
#include "shade/ramp.h"

namespace terray {
namespace {

TerrainInfo plainInfo() {
    TerrainInfo info;
    info.scheme.columns = info.scheme.rows = 3001;
    info.worldFromLattice = {{0, 30000}, {10, 0}, {0, -10}};
    info.minZ = 120;
    info.maxZ = 2875;
    return info;
}

const SceneBox kBox{{0, 0, 120}, {30000, 30000, 2875}};

RayFrame orthoFrame(int width, int height, double headingDeg = 0) {
    View view;
    view.projection = Projection::Ortho;
    view.width = width;
    view.height = height;
    view.headingDeg = headingDeg;
    const Result<Camera> camera = makeCamera(view, kBox);
    EXPECT_TRUE(camera.ok());
    return {*camera, plainInfo().worldFromLattice, 1, 0};
}

std::vector<uint8_t> picture(int width, int height, uint8_t grey) {
    std::vector<uint8_t> rgba(static_cast<size_t>(width) * static_cast<size_t>(height) * 4, grey);
    for (size_t k = 3; k < rgba.size(); k += 4) rgba[k] = 255;
    return rgba;
}

RenderOptions wanting(bool legend, bool scaleBar, bool northArrow) {
    RenderOptions options;
    options.legend = legend;
    options.scaleBar = scaleBar;
    options.northArrow = northArrow;
    return options;
}

/// The picture with annotations, drawn in bands.
std::vector<uint8_t> annotated(const RenderOptions& options, const RayFrame& rays, uint8_t grey,
                               int bandRows = 100000) {
    const int width = rays.camera().width, height = rays.camera().height;
    std::vector<uint8_t> rgba = picture(width, height, grey);
    const auto annotations = Annotations::make(options, Shading::Height, plainInfo(), rays);
    EXPECT_TRUE(annotations.ok() && *annotations);
    const size_t row = static_cast<size_t>(width) * 4;
    for (int y = 0; y < height; y += bandRows) {
        const int rows = std::min(bandRows, height - y);
        (*annotations)
            ->drawOn(y, rows,
                     std::span(rgba).subspan(static_cast<size_t>(y) * row,
                                             static_cast<size_t>(rows) * row));
    }
    return rgba;
}

/// Columns and rows that differ from plain grey.
struct Touched {
    int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;
    int darkest = 255, brightest = 0;
};
Touched touched(const std::vector<uint8_t>& rgba, int width, uint8_t grey) {
    Touched t;
    for (size_t k = 0; k < rgba.size(); k += 4) {
        if (rgba[k] == grey && rgba[k + 1] == grey && rgba[k + 2] == grey) continue;
        const int x = static_cast<int>(k / 4) % width, y = static_cast<int>(k / 4) / width;
        t.left = std::min(t.left, x);
        t.right = std::max(t.right, x);
        t.top = std::min(t.top, y);
        t.bottom = std::max(t.bottom, y);
        t.darkest = std::min<int>(t.darkest, rgba[k]);
        t.brightest = std::max<int>(t.brightest, rgba[k]);
    }
    return t;
}

TEST(Annotations, AreNothingUnlessAskedFor) {
    const auto none = Annotations::make(wanting(false, false, false), Shading::Ramp, plainInfo(),
                                        orthoFrame(9, 9));
    ASSERT_TRUE(none.ok());
    EXPECT_EQ(none->get(), nullptr);
}

TEST(Annotations, AreTheSameInAnyBands) {
    const RayFrame rays = orthoFrame(640, 360, 25);
    const RenderOptions all = wanting(true, true, true);
    const std::vector<uint8_t> whole = annotated(all, rays, 90);
    for (const int rows : {1, 7, 64, 359}) EXPECT_EQ(annotated(all, rays, 90, rows), whole);
}

TEST(Annotations, StandInTheirCornersAndAreLegibleOnAnyGround) {
    const RayFrame rays = orthoFrame(1280, 720);
    for (const uint8_t grey : {uint8_t{0}, uint8_t{128}, uint8_t{255}}) {
        const Touched legend =
            touched(annotated(wanting(true, false, false), rays, grey), 1280, grey);
        EXPECT_LT(legend.right, 1280 / 4);
        EXPECT_GT(legend.top, 720 / 3);
        for (const RenderOptions& options :
             {wanting(false, true, false), wanting(false, false, true)}) {
            const Touched t = touched(annotated(options, rays, grey), 1280, grey);
            EXPECT_GT(t.left, 1280 * 2 / 3);
            EXPECT_GT(t.top, 720 / 2);
            EXPECT_GT(t.brightest - t.darkest, 150);
        }
    }
}

TEST(Annotations, SurviveTinyPictures) {
    for (const int size : {1, 5, 40}) {
        const RayFrame rays = orthoFrame(size, size);
        annotated(wanting(true, true, true), rays, 50, 3);
    }
}

/// Length of the dark line along the bar's lower edge, in pixels.
int barLength(const std::vector<uint8_t>& rgba, int width) {
    int longest = 0;
    for (size_t row = 0; row < rgba.size() / 4; row += static_cast<size_t>(width)) {
        int run = 0;
        for (size_t x = 0; x < static_cast<size_t>(width); ++x) {
            run = rgba[4 * (row + x)] < 60 ? run + 1 : 0;
            longest = std::max(longest, run);
        }
    }
    return longest;
}

TEST(ScaleBar, OfAnOrthoPictureIsARoundLengthOfGround) {
    for (const int size : {500, 730, 1500, 3000}) {
        const RayFrame rays = orthoFrame(size, size);
        const int pixels = barLength(annotated(wanting(false, true, false), rays, 255), size);
        const double metres = pixels * rays.camera().metresPerPixel();
        const double round = roundDown125(metres * 1.05);
        EXPECT_NEAR(metres, round, 1.5 * rays.camera().metresPerPixel()) << size;
    }
}

/// Bounds of the dark ink of a north arrow.
Touched arrowInk(double headingDeg) {
    std::vector<uint8_t> rgba =
        annotated(wanting(false, false, true), orthoFrame(900, 900, headingDeg), 255);
    for (uint8_t& byte : rgba) byte = byte > 100 ? 255 : 0;
    return touched(rgba, 900, 255);
}

TEST(NorthArrow, PointsNorthInTheTurnedPicture) {
    // The letter stands beyond the tip: ink reaches further out on the north side.
    const Touched north = arrowInk(0), east = arrowInk(90), south = arrowInk(180);
    const Touched west = arrowInk(270);
    EXPECT_LT(north.top, south.top - 8);
    EXPECT_GT(south.bottom, north.bottom + 8) << "heading south, north is down";
    EXPECT_LT(east.left, west.left - 8) << "heading east, north is to the left";
    EXPECT_GT(west.right, east.right + 8);
}

TEST(Legend, HasAFewRoundLabelsInOrder) {
    std::mt19937 random(5);
    for (int k = 0; k < 300; ++k) {
        TerrainInfo info = plainInfo();
        info.minZ = std::uniform_real_distribution<float>(-500, 3000)(random);
        info.maxZ =
            info.minZ + std::pow(10.0f, std::uniform_real_distribution<float>(-1, 4)(random));
        const auto scale = legendScale(Shading::Height, info, orthoFrame(100, 100), nullptr);
        ASSERT_TRUE(scale);
        EXPECT_GE(scale->ticks.size(), 2u);
        EXPECT_LE(scale->ticks.size(), 8u);
        for (const LegendTick& tick : scale->ticks) {
            EXPECT_GE(tick.position, -1e-6);
            EXPECT_LE(tick.position, 1 + 1e-6);
            const double height =
                static_cast<double>(info.minZ) +
                tick.position * (static_cast<double>(info.maxZ) - static_cast<double>(info.minZ));
            EXPECT_NEAR(std::stod(tick.label), height, 1e-3 + 1e-5 * std::abs(height));
        }
    }
}

TEST(Legend, ShowsTheColoursOfTheShading) {
    const auto scale = legendScale(Shading::Slope, plainInfo(), orthoFrame(100, 100), nullptr);
    ASSERT_TRUE(scale);
    EXPECT_NE(scale->colour(0.1), scale->colour(0.9));
    const std::vector<ColourStop> stops{{120, 255, 0, 0, 255}, {2875, 0, 0, 255, 255}};
    const HeightRamp ramp = HeightRamp::fromStops(stops, 120, 2875);
    const auto tints = legendScale(Shading::Ramp, plainInfo(), orthoFrame(100, 100), &ramp);
    ASSERT_TRUE(tints);
    EXPECT_GT(tints->colour(0.001)[0], 240);
    EXPECT_LT(tints->colour(0.001)[2], 20);
    EXPECT_GT(tints->colour(0.999)[2], 240);
}

TEST(Legend, IsNothingWhereColoursAreNoNumbers) {
    for (const Shading shading :
         {Shading::Photo, Shading::Hillshade, Shading::Normal, Shading::Light}) {
        EXPECT_FALSE(legendScale(shading, plainInfo(), orthoFrame(100, 100), nullptr));
    }
    for (const Shading shading : {Shading::Height, Shading::Depth, Shading::Distance, Shading::Mip,
                                  Shading::Steps, Shading::Shadow}) {
        EXPECT_TRUE(legendScale(shading, plainInfo(), orthoFrame(100, 100), nullptr));
    }
}

TEST(Legend, OfFlatGroundHasOneLabel) {
    TerrainInfo info = plainInfo();
    info.maxZ = info.minZ;
    const auto scale = legendScale(Shading::Height, info, orthoFrame(100, 100), nullptr);
    ASSERT_TRUE(scale);
    ASSERT_EQ(scale->ticks.size(), 1u);
    EXPECT_EQ(scale->ticks[0].label, "120");
}

TEST(Legend, RoundLengthsAreOneTwoOrFive) {
    EXPECT_DOUBLE_EQ(roundDown125(0.99), 0.5);
    EXPECT_DOUBLE_EQ(roundDown125(1), 1);
    EXPECT_DOUBLE_EQ(roundDown125(4.9), 2);
    EXPECT_DOUBLE_EQ(roundDown125(5), 5);
    EXPECT_DOUBLE_EQ(roundDown125(12345), 10000);
    EXPECT_DOUBLE_EQ(roundDown125(0.03), 0.02);
    EXPECT_DOUBLE_EQ(roundUp125(0.03), 0.05);
    EXPECT_DOUBLE_EQ(roundUp125(5.1), 10);
    EXPECT_DOUBLE_EQ(roundUp125(200), 200);
}

}  // namespace
}  // namespace terray
