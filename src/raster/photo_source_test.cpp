// SPDX-License-Identifier: Apache-2.0
// A PhotoSource gives the very pixels of loadPhoto(), from whatever windows.
#include "raster/photo_source.h"

#include <algorithm>
#include <cmath>

#include "raster/photo.h"
#include "raster/test_photo_files.h"

namespace terray {
namespace {

constexpr const char* kUtm = "EPSG:32633";

std::string wktOf(const char* crs) { return describeCrs(crs)->wkt; }

/// Reads all of it in windows of odd sizes.
std::vector<uint8_t> inWindows(const PhotoSource& source, int64_t width, int64_t height) {
    std::vector<uint8_t> all(static_cast<size_t>(source.columns() * source.rows() * 4), 77);
    auto reader = source.makeReader();
    EXPECT_TRUE(reader.ok());
    const int64_t stride = source.columns() * 4;
    for (int64_t y = 0; y < source.rows(); y += height) {
        for (int64_t x = 0; x < source.columns(); x += width) {
            const auto read = (*reader)->read(x, y, std::min(width, source.columns() - x),
                                              std::min(height, source.rows() - y),
                                              all.data() + y * stride + x * 4, stride);
            EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().message);
        }
    }
    return all;
}

void expectSame(const std::string& path, const OpenOptions& options, const PhotoPlace& place) {
    auto photo = loadPhoto(path, options, place.workingCrsWkt, place.metresPerCrsUnit,
                           place.worldMin, place.worldMax, UINT64_MAX, place.dataCrsWkt);
    ASSERT_TRUE(photo.ok()) << photo.error().message;
    auto source = openPhotoSource(path, options, place);
    ASSERT_TRUE(source.ok()) << source.error().message;
    ASSERT_EQ((*source)->columns(), photo->width);
    ASSERT_EQ((*source)->rows(), photo->height);
    EXPECT_EQ((*source)->worldFromPixel().origin, photo->worldFromPixel.origin);
    EXPECT_EQ((*source)->description(), photo->description);
    for (const auto& [width, height] : {std::pair(97, 31), std::pair(1000, 64)}) {
        EXPECT_TRUE(inWindows(**source, width, height) == photo->rgba) << width;
    }
}

TestRaster colourful(int width, int height) {
    TestRaster raster;
    raster.width = width;
    raster.height = height;
    raster.value = [](int band, int i, int j) {
        return 127 + 120 * std::sin(0.2 * i * band) * std::cos(0.15 * j);
    };
    return raster;
}

TEST(PhotoSource, InTheWorkingCrsItGivesTheFilesPixels) {
    TestRaster raster = colourful(300, 200);
    raster.crs = kUtm;
    raster.transform = {5e5, 2, 0.25, 5.1e6, 0.25, -2};
    raster.finish = [](GDALDataset& d) { d.GetRasterBand(1)->SetNoDataValue(100); };
    const std::string path = writeRaster("photo_source_direct.tif", raster);
    expectSame(path, {}, {wktOf(kUtm), 1, {500100, 5099700}, {500500, 5099950}, 0, {}});
}

TEST(PhotoSource, WarpedItGivesTheSamePixelsFromAnyWindow) {
    TestRaster raster = colourful(300, 240);
    raster.bands = 4;
    raster.crs = "EPSG:4326";
    raster.transform = {15, 1e-4, 0, 46.1, 0, -1e-4};
    raster.finish = [](GDALDataset& d) {
        d.GetRasterBand(4)->SetColorInterpretation(GCI_AlphaBand);
    };
    const auto colour = raster.value;
    raster.value = [=](int band, int i, int j) {
        return band < 4 ? colour(band, i, j) : (i - 150) * (i - 150) + j * j < 9000 ? 255 : i % 3;
    };
    const std::string path = writeRaster("photo_source_warped.tif", raster);
    expectSame(path, {}, {wktOf(kUtm), 1, {5e5, 5102500}, {5e5 + 3000, 5.106e6}, 0, {}});
}

TEST(PhotoSource, SixteenBitsAreStretchedAlikeInEveryWindow) {
    TestRaster raster = colourful(400, 90);
    raster.bands = 1;
    raster.type = GDT_UInt16;
    raster.crs = kUtm;
    raster.transform = {5e5, 2, 0, 5.1e6, 0, -2};
    raster.value = [](int, int i, int j) { return 300 + 17 * i + 3 * j; };
    const std::string path = writeRaster("photo_source_wide.tif", raster);
    expectSame(path, {}, {wktOf(kUtm), 1, {5e5, 5099000}, {501000, 5.1e6}, 0, {}});
}

TEST(PhotoSource, OneThatDoesNotTouchTheTerrainIsRefused) {
    TestRaster raster = colourful(30, 20);
    raster.crs = kUtm;
    raster.transform = {5e5, 2, 0, 5.1e6, 0, -2};
    const std::string path = writeRaster("photo_source_far.tif", raster);
    const auto source =
        openPhotoSource(path, {}, {wktOf(kUtm), 1, {6e5, 5e6}, {601000, 5001000}, 0, {}});
    ASSERT_FALSE(source.ok());
    EXPECT_NE(source.error().message.find("does not touch"), std::string::npos);
}

}  // namespace
}  // namespace terray
