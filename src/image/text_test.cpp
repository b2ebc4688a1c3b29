// SPDX-License-Identifier: Apache-2.0
// Tests of rendered text: sizes, coverage, UTF-8, missing typefaces.
#include "image/text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>

namespace terray {
namespace {

Typeface typeface() {
    Result<Typeface> opened = Typeface::open();
    EXPECT_TRUE(opened.ok());
    return std::move(*opened);
}

float ink(const TextBitmap& bitmap) {
    return std::accumulate(bitmap.coverage.begin(), bitmap.coverage.end(), 0.0f);
}

TEST(Text, IsDrawnWithinItsBitmapAndAntiAliased) {
    const TextBitmap bitmap = typeface().render("Terray 1200 m", 20);
    ASSERT_EQ(bitmap.coverage.size(), static_cast<size_t>(bitmap.width * bitmap.height));
    EXPECT_NEAR(bitmap.height, 24, 3);
    EXPECT_TRUE(bitmap.baseline > 15 && bitmap.baseline < bitmap.height);
    bool partial = false;
    for (const float cover : bitmap.coverage) {
        ASSERT_TRUE(cover >= 0 && cover <= 1);
        partial = partial || (cover > 0.1f && cover < 0.9f);
    }
    EXPECT_TRUE(partial);
    for (int y = 0; y < bitmap.height; ++y) {
        EXPECT_EQ(bitmap.coverage[static_cast<size_t>(y * bitmap.width + bitmap.width - 1)], 0);
    }
}

TEST(Text, GrowsWithItsSize) {
    const Typeface face = typeface();
    const TextBitmap small = face.render("500 km", 10), large = face.render("500 km", 40);
    EXPECT_NEAR(large.width, 4 * small.width, 12);
    EXPECT_NEAR(ink(large) / ink(small), 16, 3);
}

TEST(Text, IsKerned) {
    const Typeface face = typeface();
    EXPECT_LT(face.render("AVAVAVAV", 60).width, face.render("AAAAVVVV", 60).width);
}

TEST(Text, ReadsUtf8AndShowsMalformedBytesAsReplacements) {
    const Typeface face = typeface();
    EXPECT_EQ(face.render("\xC3\xA9", 30).width, face.render("e", 30).width);
    EXPECT_EQ(face.render("\xC3", 30).coverage, face.render("\xEF\xBF\xBD", 30).coverage);
    EXPECT_EQ(face.render("\xFFz", 30).coverage, face.render("\xEF\xBF\xBDz", 30).coverage);
    EXPECT_NE(face.render("\xC2\xB2", 30).coverage, face.render("?", 30).coverage);
}

TEST(Text, OfNothingIsBlank) { EXPECT_EQ(ink(typeface().render("", 20)), 0); }

TEST(Text, AMissingTypefaceNamesThePackage) {
    setenv("TERRAY_FONT", "/nowhere/none.ttf", 1);
    const Result<Typeface> opened = Typeface::open();
    unsetenv("TERRAY_FONT");
    ASSERT_FALSE(opened.ok());
    EXPECT_EQ(opened.error().code, ErrorCode::Resource);
    EXPECT_THAT(opened.error().message, testing::HasSubstr("fonts-dejavu-core"));
    EXPECT_THAT(opened.error().message, testing::HasSubstr("/nowhere/none.ttf"));
}

}  // namespace
}  // namespace terray
