// SPDX-License-Identifier: Apache-2.0
// Tests of what picture files hold: every pixel, in bands or at once, georeference and metadata.
#include "image/writer.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "image/test_pictures.h"

namespace terray {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string bytesOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class WrittenPictures : public ScratchFolder {};

struct Case {
    const char* name;
    int width, height, channels;
};

class LosslessBytes : public ScratchFolder, public testing::WithParamInterface<Case> {};

TEST_P(LosslessBytes, ReadBackEqualHoweverBanded) {
    const Case& c = GetParam();
    ImageSpec spec;
    spec.width = c.width;
    spec.height = c.height;
    spec.channels = c.channels;
    const std::vector<uint8_t> pixels = seededPixels<uint8_t>(spec, 5);
    ASSERT_TRUE(writePicture(at("whole") + c.name, spec, pixels, spec.height).ok());
    EXPECT_EQ(readPixels<uint8_t>(at("whole") + c.name), pixels);
    const std::string whole = bytesOf(at("whole") + c.name);
    for (const int band : {1, 7, 64}) {
        const std::string path = at("bands" + std::to_string(band)) + c.name;
        ASSERT_TRUE(writePicture(path, spec, pixels, band).ok());
        EXPECT_EQ(bytesOf(path), whole) << band << " rows at a time";
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, LosslessBytes,
                         testing::Values(Case{".png", 101, 77, 3}, Case{".png", 64, 128, 4},
                                         Case{".png", 1, 1, 1}, Case{".tif", 101, 77, 3},
                                         Case{".tiff", 3000, 300, 4}, Case{".TIF", 1, 1, 1},
                                         Case{".tif", 500, 900, 1}));

TEST_F(WrittenPictures, JpegIsCloseAndTheSameHoweverBanded) {
    ImageSpec spec;
    spec.width = 200;
    spec.height = 131;
    std::vector<uint8_t> pixels(200 * 131 * 3);
    for (size_t k = 0; k < pixels.size(); ++k) {
        pixels[k] = static_cast<uint8_t>(k / 3 % 200 + (k % 3) * 20);
    }
    ASSERT_TRUE(writePicture(at("a.jpg"), spec, pixels, 131).ok());
    ASSERT_TRUE(writePicture(at("b.JPEG"), spec, pixels, 10).ok());
    EXPECT_EQ(bytesOf(at("a.jpg")), bytesOf(at("b.JPEG")));
    const std::vector<uint8_t> read = readPixels<uint8_t>(at("a.jpg"));
    ASSERT_EQ(read.size(), pixels.size());
    for (size_t k = 0; k < pixels.size(); ++k) ASSERT_NEAR(read[k], pixels[k], 8);
}

TEST_F(WrittenPictures, FloatTiffKeepsEveryBitAndNan) {
    for (const int channels : {1, 3}) {
        ImageSpec spec;
        spec.width = 333;
        spec.height = 290;
        spec.channels = channels;
        spec.type = PixelType::Float;
        std::vector<float> pixels = seededPixels<float>(spec, 9);
        pixels[0] = pixels[777] = kNan;
        pixels[5] = 1e-30f;
        ASSERT_TRUE(writePicture(at("a.tif"), spec, pixels, 33).ok());
        const std::vector<float> read = readPixels<float>(at("a.tif"));
        ASSERT_EQ(read.size(), pixels.size());
        EXPECT_TRUE(std::isnan(read[0]) && std::isnan(read[777]));
        for (size_t k = 0; k < pixels.size(); ++k) {
            ASSERT_TRUE(read[k] == pixels[k] || (std::isnan(read[k]) && std::isnan(pixels[k])));
        }
        GDALDatasetUniquePtr file(GDALDataset::Open(at("a.tif").c_str()));
        int hasNodata = 0;
        EXPECT_TRUE(std::isnan(file->GetRasterBand(channels)->GetNoDataValue(&hasNodata)));
        EXPECT_TRUE(hasNodata);
    }
    EXPECT_EQ(names().size(), 1u) << "no side files";
}

std::vector<float> readExrChannel(const std::string& path, const char* name) {
    Imf::InputFile file(path.c_str());
    const Imath::Box2i window = file.header().dataWindow();
    const size_t width = static_cast<size_t>(window.max.x + 1);
    std::vector<float> values(width * static_cast<size_t>(window.max.y + 1), -1.0f);
    if (!file.header().channels().findChannel(name)) return {};
    Imf::FrameBuffer buffer;
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()),
                                   sizeof(float), sizeof(float) * width));
    file.setFrameBuffer(buffer);
    file.readPixels(0, window.max.y);
    return values;
}

TEST_F(WrittenPictures, ExrKeepsNamedFloatChannels) {
    ImageSpec spec;
    spec.width = 65;
    spec.height = 150;
    spec.type = PixelType::Float;
    spec.channelNames = {"X", "Y", "Z"};
    std::vector<float> pixels = seededPixels<float>(spec, 2);
    pixels[3 * 70] = kNan;
    for (const int band : {150, 1, 37}) {
        ASSERT_TRUE(writePicture(at("a.exr"), spec, pixels, band).ok());
        const char* channels[3] = {"X", "Y", "Z"};
        for (size_t c = 0; c < 3; ++c) {
            const std::vector<float> read = readExrChannel(at("a.exr"), channels[c]);
            ASSERT_EQ(read.size() * 3, pixels.size());
            for (size_t k = 0; k < read.size(); ++k) {
                ASSERT_EQ(std::memcmp(&read[k], &pixels[k * 3 + c], sizeof(float)), 0);
            }
        }
    }
}

TEST_F(WrittenPictures, ExrHalfColoursAreAssociatedWithAlpha) {
    ImageSpec spec;
    spec.width = 2;
    spec.height = 1;
    spec.channels = 4;
    spec.type = PixelType::Float;
    spec.halfFloat = true;
    const std::vector<float> pixels{1, 0.5f, 2, 0.5f, 3, 4, 5, 0};
    ASSERT_TRUE(writePicture(at("a.exr"), spec, pixels, 1).ok());
    EXPECT_THAT(readExrChannel(at("a.exr"), "R"), testing::ElementsAre(0.5f, 0));
    EXPECT_THAT(readExrChannel(at("a.exr"), "G"), testing::ElementsAre(0.25f, 0));
    EXPECT_THAT(readExrChannel(at("a.exr"), "A"), testing::ElementsAre(0.5f, 0));
    EXPECT_EQ(Imf::InputFile(at("a.exr").c_str()).header().channels().findChannel("R")->type,
              Imf::HALF);
}

TEST_F(WrittenPictures, GeoreferenceIsOfThePixelCorner) {
    OGRSpatialReference utm;
    utm.importFromEPSG(32632);
    char* wkt = nullptr;
    utm.exportToWkt(&wkt);
    ImageSpec spec;
    spec.width = 10;
    spec.height = 5;
    spec.georeference = GeoReference{wkt, 500000.25, 4e6 + 50, 2.5, -2.5};
    spec.description = "Terray test";
    CPLFree(wkt);
    ASSERT_TRUE(writePicture(at("a.tif"), spec, std::vector<uint8_t>(150, 7), 5).ok());
    GDALDatasetUniquePtr file(GDALDataset::Open(at("a.tif").c_str()));
    ASSERT_TRUE(file);
    double transform[6];
    ASSERT_EQ(file->GetGeoTransform(transform), CE_None);
    EXPECT_THAT(transform, testing::ElementsAre(500000.25, 2.5, 0, 4e6 + 50, 0, -2.5));
    ASSERT_TRUE(file->GetSpatialRef());
    EXPECT_STREQ(file->GetSpatialRef()->GetAuthorityCode(nullptr), "32632");
    EXPECT_STREQ(file->GetMetadataItem("TIFFTAG_IMAGEDESCRIPTION"), "Terray test");
    EXPECT_STRNE(file->GetMetadataItem("AREA_OR_POINT"), "Point");
    EXPECT_EQ(names().size(), 1u) << "no side files";
}

TEST_F(WrittenPictures, PngCarriesTheDescriptionAndSrgb) {
    ImageSpec spec;
    spec.width = 3;
    spec.height = 2;
    spec.description = "made by a test";
    ASSERT_TRUE(writePicture(at("a.png"), spec, std::vector<uint8_t>(18, 7), 2).ok());
    const std::string bytes = bytesOf(at("a.png"));
    EXPECT_THAT(bytes, testing::HasSubstr("made by a test"));
    EXPECT_THAT(bytes, testing::HasSubstr("sRGB"));
}

TEST_F(WrittenPictures, AlphaIsMarkedStraightInTiff) {
    ImageSpec spec;
    spec.width = 3;
    spec.height = 2;
    spec.channels = 4;
    ASSERT_TRUE(writePicture(at("a.tif"), spec, std::vector<uint8_t>(24, 7), 2).ok());
    GDALDatasetUniquePtr file(GDALDataset::Open(at("a.tif").c_str()));
    EXPECT_EQ(file->GetRasterBand(4)->GetColorInterpretation(), GCI_AlphaBand);
}

TEST(PictureFormats, OnlyExrIsLinear) {
    EXPECT_TRUE(isLinearFormat("a.exr"));
    EXPECT_TRUE(isLinearFormat("a.b.EXR"));
    EXPECT_FALSE(isLinearFormat("a.png"));
    EXPECT_FALSE(isLinearFormat("exr"));
}

}  // namespace
}  // namespace terray
