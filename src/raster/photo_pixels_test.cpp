// SPDX-License-Identifier: Apache-2.0
// Tests of a photo's colours: bands, palettes, alpha, nodata and stretches.
#include "raster/photo_pixels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raster/test_photo_files.h"

namespace terray {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

struct Picture {
    std::vector<uint8_t> rgba;
    int width = 0;
    std::string description;
    std::vector<int> at(int i, int j) const {
        const uint8_t* const p = rgba.data() + (j * width + i) * 4;
        return {p[0], p[1], p[2], p[3]};
    }
};

Picture readAll(const std::string& path, const OpenOptions& options = {}) {
    const DatasetHandle dataset(GDALDataset::Open(path.c_str()));
    auto pixels = PhotoPixels::make(*dataset, path, options);
    EXPECT_TRUE(pixels) << pixels.error().message;
    const int width = dataset->GetRasterXSize(), height = dataset->GetRasterYSize();
    Picture picture;
    picture.width = width;
    picture.rgba.resize(static_cast<size_t>(width) * static_cast<size_t>(height) * 4);
    EXPECT_TRUE(pixels->read({0, 0, width, height, width, height}, picture.rgba.data()));
    picture.description = pixels->description();
    return picture;
}

Result<PhotoPixels> makeFrom(const std::string& path, const OpenOptions& options) {
    const DatasetHandle dataset(GDALDataset::Open(path.c_str()));
    return PhotoPixels::make(*dataset, path, options);
}

TEST(PhotoPixels, GreyBecomesGrey) {
    const Picture grey = readAll(writeRaster(
        "grey.tif", {.width = 9, .height = 5, .bands = 1, .value = [](int, int i, int j) {
                         return i * 10 + j;
                     }}));
    EXPECT_THAT(grey.at(3, 2), ElementsAre(32, 32, 32, 255));
}

TEST(PhotoPixels, PalettesAreExpanded) {
    const Picture picture = readAll(writeRaster(
        "palette.tif", {.width = 4,
                        .height = 1,
                        .bands = 1,
                        .value = [](int, int i, int) { return i; },
                        .finish =
                            [](GDALDataset& dataset) {
                                GDALColorTable table;
                                const std::array<GDALColorEntry, 3> entries{
                                    {{10, 20, 30, 255}, {200, 100, 50, 255}, {1, 2, 3, 255}}};
                                for (int k = 0; k < 3; ++k) {
                                    table.SetColorEntry(k, &entries[static_cast<size_t>(k)]);
                                }
                                dataset.GetRasterBand(1)->SetColorTable(&table);
                            }}));
    EXPECT_THAT(picture.at(0, 0), ElementsAre(10, 20, 30, 255));
    EXPECT_THAT(picture.at(1, 0), ElementsAre(200, 100, 50, 255));
    EXPECT_THAT(picture.description, HasSubstr("palette"));
}

TEST(PhotoPixels, AlphaBandsMakeTransparent) {
    const std::string path = writeRaster(
        "alpha.tif", {.width = 3,
                      .height = 1,
                      .bands = 4,
                      .value = [](int band, int i, int) { return band == 4 ? i * 127 : 50 * band; },
                      .finish =
                          [](GDALDataset& dataset) {
                              dataset.GetRasterBand(1)->SetColorInterpretation(GCI_RedBand);
                              dataset.GetRasterBand(2)->SetColorInterpretation(GCI_GreenBand);
                              dataset.GetRasterBand(3)->SetColorInterpretation(GCI_BlueBand);
                              dataset.GetRasterBand(4)->SetColorInterpretation(GCI_AlphaBand);
                          }});
    const Picture picture = readAll(path);
    EXPECT_THAT(picture.at(0, 0), ElementsAre(0, 0, 0, 0));
    EXPECT_THAT(picture.at(1, 0), ElementsAre(50, 100, 150, 127));
    EXPECT_THAT(picture.at(2, 0), ElementsAre(50, 100, 150, 254));
}

TEST(PhotoPixels, NodataCountsOnlyWhereAllBandsHaveIt) {
    const Picture picture = readAll(writeRaster(
        "nodata.tif",
        {.width = 4,
         .height = 1,
         .value = [](int band, int i, int) { return band <= i ? 255 : 7; },
         .finish = [](GDALDataset& dataset) { dataset.GetRasterBand(1)->SetNoDataValue(255); }}));
    EXPECT_THAT(picture.at(0, 0), ElementsAre(7, 7, 7, 255));
    EXPECT_THAT(picture.at(2, 0), ElementsAre(255, 255, 7, 255));
    EXPECT_THAT(picture.at(3, 0), ElementsAre(0, 0, 0, 0));
}

TEST(PhotoPixels, MaskBandsMakeTransparent) {
    const Picture picture = readAll(writeRaster(
        "mask.tif", {.width = 2,
                     .height = 1,
                     .value = [](int band, int, int) { return 10 * band; },
                     .finish =
                         [](GDALDataset& dataset) {
                             dataset.CreateMaskBand(GMF_PER_DATASET);
                             std::array<uint8_t, 2> mask{0, 255};
                             EXPECT_EQ(dataset.GetRasterBand(1)->GetMaskBand()->RasterIO(
                                           GF_Write, 0, 0, 2, 1, mask.data(), 2, 1, GDT_Byte, 0, 0,
                                           nullptr),
                                       CE_None);
                         }}));
    EXPECT_THAT(picture.at(0, 0), ElementsAre(0, 0, 0, 0));
    EXPECT_THAT(picture.at(1, 0), ElementsAre(10, 20, 30, 255));
}

double ramp16(int band, int i, int j) { return 1000.0 * band + i + 100.0 * j; }

TEST(PhotoPixels, SixteenBitsAreStretchedByDefaultAndSaySo) {
    const std::string path = writeRaster(
        "wide.tif", {.width = 100, .height = 100, .bands = 5, .type = GDT_UInt16, .value = ramp16});
    const Picture picture = readAll(path);
    EXPECT_THAT(picture.description, HasSubstr("stretched from 2 to 98 %"));
    EXPECT_THAT(picture.description, HasSubstr("bands 1, 2, 3"));
    EXPECT_THAT(picture.description, HasSubstr("does not say"));
    EXPECT_EQ(picture.at(0, 0)[0], 0);
    EXPECT_EQ(picture.at(99, 99)[0], 255);
    EXPECT_NEAR(picture.at(0, 50)[1], 128, 2);
}

TEST(PhotoPixels, BandsAndPercentilesAreTheUsers) {
    const std::string path = writeRaster("user.tif", {.width = 101,
                                                      .height = 1,
                                                      .bands = 4,
                                                      .type = GDT_Float32,
                                                      .value = [](int band, int i, int) {
                                                          return band == 2 ? 100.0 - i : band * i;
                                                      }});
    OpenOptions options;
    options.photoBands = {3, 2, 1};
    options.photoStretch = {{10, 90}};
    const Picture picture = readAll(path, options);
    EXPECT_THAT(picture.description, HasSubstr("bands 3, 2, 1, stretched from 10 to 90 %"));
    for (const int i : {0, 10, 35, 50, 90, 100}) {
        const double share = std::clamp((i - 10) / 80.0, 0.0, 1.0);
        EXPECT_NEAR(picture.at(i, 0)[0], 255 * share, 1) << i;
        EXPECT_NEAR(picture.at(i, 0)[1], 255 * (1 - share), 1) << i;
        EXPECT_NEAR(picture.at(i, 0)[2], 255 * share, 1) << i;
    }
    options.photoBands = {2};
    EXPECT_EQ(readAll(path, options).at(10, 0)[2], 255);
}

TEST(PhotoPixels, NanIsTransparentAndDoesNotSpoilTheStretch) {
    const Picture picture = readAll(writeRaster(
        "nan.tif",
        {.width = 101, .height = 1, .bands = 1, .type = GDT_Float32, .value = [](int, int i, int) {
             return i == 7 ? std::numeric_limits<double>::quiet_NaN() : double(i);
         }}));
    EXPECT_THAT(picture.at(7, 0), ElementsAre(0, 0, 0, 0));
    EXPECT_NEAR(picture.at(50, 0)[0], 127, 3);
    EXPECT_EQ(picture.at(50, 0)[3], 255);
}

TEST(PhotoPixels, OneValueEverywhereIsNoError) {
    const Picture picture = readAll(writeRaster(
        "flat.tif", {.width = 5, .height = 5, .type = GDT_UInt16, .value = [](int, int, int) {
                         return 4000;
                     }}));
    EXPECT_EQ(picture.at(2, 2)[3], 255);
}

// large enough for several strips: no seam, no drift
TEST(PhotoPixels, ReducedReadsAverageTheirPartOfTheRaster) {
    const auto value = [](int band, int i, int j) { return band * 100.0 + 2 * i + 3 * j; };
    for (const GDALDataType type : {GDT_Byte, GDT_UInt16}) {
        const bool isByte = type == GDT_Byte;
        const std::string path = writeRaster(
            "reduced.tif",
            {.width = 2900,
             .height = 3100,
             .bands = 1,
             .type = type,
             .value = [&](int, int i, int j) { return isByte ? (i + j) / 25.0 : value(1, i, j); }});
        const DatasetHandle dataset(GDALDataset::Open(path.c_str()));
        OpenOptions options;
        if (!isByte) options.photoStretch = {{0, 100}};
        auto pixels = PhotoPixels::make(*dataset, path, options);
        ASSERT_TRUE(pixels);
        const PhotoWindow window{100, 50, 2700, 3000, 2500, 2777};
        std::vector<uint8_t> rgba(static_cast<size_t>(window.outWidth * window.outHeight) * 4);
        ASSERT_TRUE(pixels->read(window, rgba.data()));
        const double lowest = value(1, 100, 50), highest = value(1, 2799, 3049);
        for (int j = 0; j < window.outHeight; j += 3) {
            for (int i = 0; i < window.outWidth; i += 7) {
                const double x = 100 + (i + 0.5) * 2700 / 2500 - 0.5;
                const double y = 50 + (j + 0.5) * 3000 / 2777 - 0.5;
                const double wanted =
                    isByte ? (x + y) / 25
                           : 255 * (100 + 2 * x + 3 * y - lowest) / (highest - lowest);
                ASSERT_NEAR(rgba[static_cast<size_t>(j * window.outWidth + i) * 4], wanted, 1.2)
                    << i << " " << j;
            }
        }
    }
}

TEST(PhotoPixels, BadOptionsAreUsageErrors) {
    const std::string path = writeRaster(
        "options.tif", {.width = 4, .height = 4, .value = [](int, int, int) { return 1; }});
    for (const std::vector<int>& bands :
         {std::vector<int>{1, 2}, {1, 2, 4}, {0}, {1, 2, 3, 1}, {-1, 2, 3}}) {
        OpenOptions options;
        options.photoBands = bands;
        const auto pixels = makeFrom(path, options);
        ASSERT_FALSE(pixels);
        EXPECT_EQ(pixels.error().code, ErrorCode::Usage);
        EXPECT_THAT(pixels.error().message, HasSubstr("--photo-bands"));
    }
    for (const auto& [low, high] :
         {std::pair{50.0, 50.0}, {-1.0, 98.0}, {2.0, 101.0}, {98.0, 2.0}, {std::nan(""), 98.0}}) {
        OpenOptions options;
        options.photoStretch = {{low, high}};
        const auto pixels = makeFrom(path, options);
        ASSERT_FALSE(pixels);
        EXPECT_EQ(pixels.error().code, ErrorCode::Usage);
        EXPECT_THAT(pixels.error().message, HasSubstr("--photo-stretch"));
    }
    const std::string complex = writeRaster(
        "complex.tif",
        {.width = 4, .height = 4, .bands = 1, .type = GDT_CFloat32, .value = [](int, int, int) {
             return 1;
         }});
    EXPECT_EQ(makeFrom(complex, {}).error().code, ErrorCode::Input);
}

}  // namespace
}  // namespace terray
