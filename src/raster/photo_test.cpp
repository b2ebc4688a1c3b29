// SPDX-License-Identifier: Apache-2.0
// Tests of loadPhoto: where the pixels come to lie, warped or not, and what is refused.
#include "raster/photo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "geo/frame.h"
#include "raster/test_photo_files.h"

namespace terray {
namespace {

using testing::HasSubstr;

constexpr uint64_t kPlenty = 1u << 28;

std::string wktOf(const std::string& crs) { return describeCrs(crs)->wkt; }

const uint8_t* pixel(const Photo& photo, int64_t i, int64_t j) {
    return photo.rgba.data() + (j * photo.width + i) * 4;
}

Photo load(const std::string& path, const std::string& crs, Vec2 lo, Vec2 hi,
           uint64_t maxBytes = kPlenty) {
    auto photo = loadPhoto(path, {}, crs.empty() ? "" : wktOf(crs), 1, lo, hi, maxBytes);
    EXPECT_TRUE(photo) << photo.error().message;
    return photo ? std::move(*photo) : Photo{};
}

double byteOf(int band, int i, int j) { return (i * 3 + j * 5 + band * 40) % 251; }

TEST(Photo, InTheSameCrsIsTakenPixelForPixel) {
    const std::string path = writeRaster("photo_same.tif", {.width = 60,
                                                            .height = 40,
                                                            .crs = "EPSG:32633",
                                                            .transform = {5e5, 10, 0, 6e6, 0, -10},
                                                            .value = byteOf});
    const Photo photo = load(path, "EPSG:32633", {0, 0}, {1e7, 1e7});
    ASSERT_EQ(photo.width, 60);
    ASSERT_EQ(photo.height, 40);
    EXPECT_EQ(photo.worldFromPixel.worldFromLattice({0, 0}), Vec2(5e5 + 5, 6e6 - 5));
    EXPECT_EQ(photo.worldFromPixel.worldFromLattice({59, 39}), Vec2(5e5 + 595, 6e6 - 395));
    for (int j = 0; j < 40; ++j) {
        for (int i = 0; i < 60; ++i) {
            for (int c = 0; c < 3; ++c) ASSERT_EQ(pixel(photo, i, j)[c], byteOf(c + 1, i, j));
            ASSERT_EQ(pixel(photo, i, j)[3], 255);
        }
    }
}

TEST(Photo, ReadsOnlyThePartOverTheTerrainEvenWhenRotated) {
    const Affine2 place{{5e5, 6e6}, {8, 6}, {6, -8}};  // of pixel corners
    const std::string path = writeRaster("photo_rotated.tif", {.width = 300,
                                                               .height = 300,
                                                               .crs = "EPSG:32633",
                                                               .transform = {5e5, 8, 6, 6e6, 6, -8},
                                                               .value = byteOf});
    const Vec2 middle = place.worldFromLattice({150, 150});
    const Photo photo = load(path, "EPSG:32633", middle - 100.0, middle + 100.0);
    EXPECT_LT(photo.width, 60);
    EXPECT_GT(photo.width, 20);
    const LatticePoint at =
        photo.worldFromPixel.latticeFromWorld(place.worldFromLattice({150.5, 152.5}));
    EXPECT_NEAR(at.i, std::round(at.i), 1e-6);
    const uint8_t* const found = pixel(photo, std::lround(at.i), std::lround(at.j));
    EXPECT_EQ(found[0], byteOf(1, 150, 152));
    EXPECT_EQ(found[2], byteOf(3, 150, 152));
}

TEST(Photo, CountsFeetOfTheWorkingCrsInMetres) {
    const double foot = 1200.0 / 3937.0;
    const std::string path = writeRaster("photo_feet.tif", {.width = 10,
                                                            .height = 10,
                                                            .crs = "EPSG:2264",
                                                            .transform = {1e6, 30, 0, 6e5, 0, -30},
                                                            .value = byteOf});
    const auto photo = loadPhoto(path, {}, wktOf("EPSG:2264"), foot, {0, 0}, {1e6, 1e6}, kPlenty);
    ASSERT_TRUE(photo) << photo.error().message;
    EXPECT_NEAR(photo->worldFromPixel.columnLength(), 30 * foot, 1e-9);
    EXPECT_NEAR(photo->worldFromPixel.origin.x, (1e6 + 15) * foot, 1e-6);
}

/// Smooth colours of a place, so that a warped pixel tells where it comes from.
std::array<double, 3> colourOf(Vec2 lonLat) {
    return {128 + 100 * std::sin(lonLat.x * 9), 128 + 100 * std::sin(lonLat.y * 11),
            128 + 100 * std::sin((lonLat.x + lonLat.y) * 7)};
}

/// A picture in degrees: `west` and `north` are its corner, pixels of `step` degrees.
std::string writeDegrees(const std::string& name, double west, double north, double step, int width,
                         int height) {
    return writeRaster(name, {.width = width,
                              .height = height,
                              .crs = "EPSG:4326",
                              .transform = {west, step, 0, north, 0, -step},
                              .value = [=](int band, int i, int j) {
                                  return std::round(colourOf(
                                      {west + (i + 0.5) * step,
                                       north - (j + 0.5) * step})[static_cast<size_t>(band - 1)]);
                              }});
}

/// Every opaque pixel has the colour of its place; gives the share of opaque ones.
double checkColours(const Photo& photo, const std::string& crs, double middleLongitude) {
    const GeoFrame frame = GeoFrame::make(crs, crs).value();
    int64_t opaque = 0;
    for (int j = 0; j < photo.height; ++j) {
        for (int i = 0; i < photo.width; ++i) {
            if (pixel(photo, i, j)[3] != 255) continue;
            ++opaque;
            Vec2 place = *frame.lonLatFromWorld(
                photo.worldFromPixel.worldFromLattice({double(i), double(j)}));
            place.x += 360 * std::round((middleLongitude - place.x) / 360);
            for (size_t c = 0; c < 3; ++c) {
                // the rim's half pixel repeats its edge
                EXPECT_NEAR(pixel(photo, i, j)[c], colourOf(place)[c], 3.0) << i << " " << j;
            }
            if (testing::Test::HasFailure()) return 0;
        }
    }
    return static_cast<double>(opaque) / (double(photo.width) * photo.height);
}

TEST(Photo, InDegreesIsWarpedToItsPlaces) {
    const std::string path = writeDegrees("photo_degrees.tif", 14, 47, 0.005, 200, 200);
    const GeoFrame frame = GeoFrame::make("EPSG:4326", "EPSG:32633").value();
    const Vec2 middle = *frame.worldFromData({14.5, 46.5});
    const Photo photo = load(path, "EPSG:32633", middle - 20000.0, middle + 20000.0);
    EXPECT_EQ(checkColours(photo, "EPSG:32633", 14.5), 1);
    // pixels of the finer ground size: 0.005 degrees of longitude at 46.5 degrees
    EXPECT_NEAR(photo.worldFromPixel.columnLength(), 0.005 * 111320 * std::cos(radFromDeg(46.5)),
                3);
    EXPECT_THAT(photo.description, HasSubstr("warped"));
    const Vec2 corner = photo.worldFromPixel.worldFromLattice({-0.5, -0.5});
    EXPECT_NEAR(corner.x, middle.x - 20000, 1e-3);
    EXPECT_NEAR(corner.y, middle.y + 20000, 1e-3);
}

TEST(Photo, ThatCoversAPartIsTransparentBeyond) {
    const std::string path = writeDegrees("photo_part.tif", 14, 47, 0.005, 100, 100);
    const GeoFrame frame = GeoFrame::make("EPSG:4326", "EPSG:32633").value();
    const Vec2 corner = *frame.worldFromData({14, 47});
    const Photo photo = load(path, "EPSG:32633", corner - 1e5, corner + 1e5);
    const double share = checkColours(photo, "EPSG:32633", 14.25);
    EXPECT_GT(share, 0.9);  // only the strips beside the turned square are empty
    EXPECT_LT(share, 1.0);
    EXPECT_LT(photo.width * photo.worldFromPixel.columnLength(), 45000);
}

TEST(Photo, IsFoundAcrossTheAntimeridian) {
    const GeoFrame frame = GeoFrame::make("EPSG:4326", "EPSG:32601").value();
    const Vec2 middle = *frame.worldFromData({-179.6, 10});
    const Vec2 lo = middle - 20000.0, hi = middle + 20000.0;
    // the same ground as a file around 180 and as one from 0 to 360
    for (const double west : {179.0, 0.0}) {
        const std::string path =
            writeDegrees("photo_180.tif", west, 11, 0.02, west > 0 ? 200 : 18000, 100);
        EXPECT_EQ(checkColours(load(path, "EPSG:32601", lo, hi), "EPSG:32601", 180.4), 1) << west;
    }
    const Vec2 onIt = *frame.worldFromData({180, 10});
    const std::string world = writeDegrees("photo_world.tif", -180, 11, 0.02, 18000, 100);
    const Photo photo = load(world, "EPSG:32601", onIt - 20000.0, onIt + 20000.0);
    size_t covered = 0;
    for (size_t k = 3; k < photo.rgba.size(); k += 4) covered += photo.rgba[k] == 255;
    EXPECT_GT(covered, photo.rgba.size() / 4 * 9 / 10);
}

TEST(Photo, WithoutGeoreferenceIsStretchedOverTheTerrain) {
    const std::string path =
        writeRaster("photo_plain.tif", {.width = 50, .height = 20, .value = byteOf});
    const Photo photo = load(path, "EPSG:32633", {1000, 2000}, {2000, 2600});
    EXPECT_THAT(photo.description, HasSubstr("stretched over the terrain"));
    EXPECT_EQ(photo.worldFromPixel.worldFromLattice({-0.5, -0.5}), Vec2(1000, 2600));
    EXPECT_EQ(photo.worldFromPixel.worldFromLattice({49.5, 19.5}), Vec2(2000, 2000));
    EXPECT_EQ(pixel(photo, 7, 3)[0], byteOf(1, 7, 3));
}

TEST(Photo, WithoutCrsIsLaidByItsCoordinates) {
    const std::string path = writeRaster(
        "photo_nocrs.tif",
        {.width = 10, .height = 10, .transform = {100, 2, 0, 100, 0, -2}, .value = byteOf});
    for (const char* crs : {"", "EPSG:32633"}) {
        const Photo photo = load(path, crs, {100, 80}, {120, 100});
        EXPECT_EQ(photo.width, 10);
        EXPECT_EQ(photo.worldFromPixel.origin, Vec2(101, 99));
    }
    const auto elsewhere = loadPhoto(path, {}, "", 1, {1e5, 1e5}, {2e5, 2e5}, kPlenty);
    ASSERT_FALSE(elsewhere);
    EXPECT_THAT(elsewhere.error().message, HasSubstr("no CRS"));
}

TEST(Photo, WithoutCrsIsInTheOneOfTheDem) {
    const std::string path = writeRaster(
        "photo_degrees.tif",
        {.width = 20, .height = 20, .transform = {14.9, 0.01, 0, 50.1, 0, -0.01}, .value = byteOf});
    const Vec2 lo{499000, 5538000}, hi{501000, 5540000};
    const auto photo =
        loadPhoto(path, {}, wktOf("EPSG:32633"), 1, lo, hi, kPlenty, wktOf("EPSG:4326"));
    ASSERT_TRUE(photo) << photo.error().message;
    EXPECT_THAT(photo->description, HasSubstr("no CRS"));
    const auto outside = loadPhoto(path, {}, wktOf("EPSG:32633"), 1, hi + 1e5, hi + 2e5, kPlenty,
                                   wktOf("EPSG:4326"));
    ASSERT_FALSE(outside);
    EXPECT_THAT(outside.error().message, HasSubstr("no CRS"));
}

TEST(Photo, StaysWithinTheMemoryGiven) {
    const std::string same = writeRaster(
        "photo_big.tif", {.width = 1000,
                          .height = 500,
                          .crs = "EPSG:32633",
                          .transform = {5e5, 10, 0, 6e6, 0, -10},
                          .value = [](int band, int i, int) { return i * 0.2 + band; }});
    const Photo photo = load(same, "EPSG:32633", {0, 0}, {1e7, 1e7}, 200000);
    EXPECT_LE(photo.rgba.size(), 203000u);
    EXPECT_GT(photo.rgba.size(), 150000u);
    EXPECT_THAT(photo.description, HasSubstr("reduced"));
    const Vec2 centre = photo.worldFromPixel.worldFromLattice({(photo.width - 1) / 2.0, 0});
    EXPECT_NEAR(centre.x, 5e5 + 5000, 1e-6);
    EXPECT_NEAR(pixel(photo, photo.width / 2, 5)[0], 101, 2);
    const std::string degrees = writeDegrees("photo_big_degrees.tif", 14, 47, 0.002, 500, 500);
    const Photo warped = load(degrees, "EPSG:32633", {0, 0}, {1e7, 1e7}, 300000);
    EXPECT_LE(warped.rgba.size(), 200000u);
    EXPECT_GT(warped.rgba.size(), 50000u);
}

TEST(Photo, IsRefusedWithTheReason) {
    const Vec2 lo{5e5, 6e6}, hi{5.1e5, 6.1e6};
    const std::string crs = wktOf("EPSG:32633");
    const auto codeOf = [&](const std::string& path) {
        const auto photo = loadPhoto(path, {}, crs, 1, lo, hi, kPlenty);
        EXPECT_FALSE(photo) << path;
        EXPECT_THAT(photo ? "" : photo.error().message, HasSubstr(path));
        return photo ? ErrorCode::Failed : photo.error().code;
    };
    EXPECT_EQ(codeOf(testing::TempDir() + "no_such_photo.tif"), ErrorCode::Input);
    EXPECT_EQ(codeOf(writeDegrees("photo_far.tif", -70, 47, 0.01, 50, 50)), ErrorCode::Input);
    EXPECT_EQ(codeOf(writeRaster("photo_far_same.tif", {.width = 10,
                                                        .height = 10,
                                                        .crs = "EPSG:32633",
                                                        .transform = {0, 10, 0, 0, 0, -10},
                                                        .value = byteOf})),
              ErrorCode::Input);
    const std::string cut = writeRaster("photo_cut.tif", {.width = 600,
                                                          .height = 600,
                                                          .crs = "EPSG:32633",
                                                          .transform = {5e5, 10, 0, 6.05e6, 0, -10},
                                                          .value = byteOf});
    std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
    EXPECT_EQ(codeOf(cut), ErrorCode::Input);
}

}  // namespace
}  // namespace terray
