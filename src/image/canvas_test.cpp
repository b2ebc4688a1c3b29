// SPDX-License-Identifier: Apache-2.0
// Tests of drawings laid over pictures.
#include "image/canvas.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace terray {
namespace {

constexpr Ink kBlack{0, 0, 0}, kWhite{255, 255, 255}, kRed{255, 0, 0};

std::vector<uint8_t> greyPicture(int width, int height, uint8_t grey, uint8_t alpha) {
    std::vector<uint8_t> rgba;
    for (int k = 0; k < width * height; ++k) rgba.insert(rgba.end(), {grey, grey, grey, alpha});
    return rgba;
}

TEST(Canvas, RectanglesLandOnTheirPixels) {
    Canvas canvas(4, 3);
    canvas.fillRectangle(1, 1, 3, 2, kRed);
    canvas.fillRectangle(-5, -5, 1, 1, kBlack);
    std::vector<uint8_t> rgba = greyPicture(10, 8, 100, 255);
    canvas.composeOn(5, 4, 10, 0, 8, rgba);
    for (int y = 0; y < 8; ++y) {
        for (int x = 0; x < 10; ++x) {
            const uint8_t* pixel = &rgba[static_cast<size_t>(4 * (y * 10 + x))];
            const bool red = y == 5 && (x == 6 || x == 7), black = y == 4 && x == 5;
            EXPECT_EQ(pixel[0], red ? 255 : black ? 0 : 100);
            EXPECT_EQ(pixel[1], red || black ? 0 : 100);
            EXPECT_EQ(pixel[3], 255);
        }
    }
}

TEST(Canvas, PolygonsCoverTheirArea) {
    Canvas canvas(40, 40);
    const Vec2 triangle[] = {{5, 5}, {35, 8}, {12, 33}};
    canvas.fillPolygon(triangle, kWhite);
    std::vector<uint8_t> rgba = greyPicture(40, 40, 0, 255);
    canvas.composeOn(0, 0, 40, 0, 40, rgba);
    double area = 0;
    for (size_t k = 0; k < rgba.size(); k += 4) area += rgba[k] / 255.0;
    EXPECT_NEAR(area, 0.5 * (30 * 28 - 3 * 7), 4);
}

TEST(Canvas, IsTheSameInAnyBands) {
    std::mt19937 random(4);
    Canvas canvas(30, 25);
    const Vec2 kite[] = {{3, 20}, {15.5, 2}, {28, 22}, {15, 15}};
    canvas.fillPolygon(kite, kBlack);
    canvas.addHalo(3, kWhite, 0.8f);
    std::vector<uint8_t> picture(4 * 50 * 40);
    for (uint8_t& byte : picture) byte = static_cast<uint8_t>(random());
    std::vector<uint8_t> whole = picture;
    canvas.composeOn(-4, 22, 50, 0, 40, whole);
    for (int row = 0; row < 40; row += 8) {
        canvas.composeOn(-4, 22, 50, row, 8, std::span(picture).subspan(4 * 50 * row, 4 * 50 * 8));
    }
    EXPECT_EQ(picture, whole);
}

TEST(Canvas, HaloSetsInkOffFromItsOwnColour) {
    Canvas canvas(21, 21);
    canvas.fillRectangle(10, 5, 11, 16, kBlack);
    canvas.addHalo(3, kWhite, 0.8f);
    std::vector<uint8_t> rgba = greyPicture(21, 21, 0, 255);
    canvas.composeOn(0, 0, 21, 0, 21, rgba);
    EXPECT_EQ(rgba[4 * (10 * 21 + 10)], 0) << "the ink itself";
    EXPECT_GT(rgba[4 * (10 * 21 + 12)], 100) << "beside it";
    EXPECT_EQ(rgba[4 * (10 * 21 + 20)], 0) << "far from it";
}

TEST(Canvas, ShowsOnTransparentPicturesWithStraightAlpha) {
    Canvas canvas(1, 1);
    canvas.fillRectangle(0, 0, 1, 1, kRed);
    std::vector<uint8_t> rgba = greyPicture(1, 1, 77, 0);
    canvas.composeOn(0, 0, 1, 0, 1, rgba);
    EXPECT_EQ(rgba, (std::vector<uint8_t>{255, 0, 0, 255}));
}

TEST(Canvas, TextIsAligned) {
    TextBitmap text;
    text.width = 4;
    text.height = 2;
    text.baseline = 2;
    text.coverage.assign(8, 1.0f);
    const struct {
        TextAlign align;
        int left;
    } cases[] = {{TextAlign::Left, 10}, {TextAlign::Centre, 8}, {TextAlign::Right, 6}};
    for (const auto& c : cases) {
        Canvas canvas(20, 5);
        canvas.drawText(text, 10, 4, c.align, kWhite);
        std::vector<uint8_t> rgba = greyPicture(20, 5, 0, 255);
        canvas.composeOn(0, 0, 20, 0, 5, rgba);
        for (int y = 0; y < 5; ++y) {
            for (int x = 0; x < 20; ++x) {
                const bool inside = x >= c.left && x < c.left + 4 && (y == 2 || y == 3);
                EXPECT_EQ(rgba[static_cast<size_t>(4 * (y * 20 + x))], inside ? 255 : 0);
            }
        }
    }
}

}  // namespace
}  // namespace terray
