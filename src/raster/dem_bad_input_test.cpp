// SPDX-License-Identifier: Apache-2.0
// Tests of what is refused: one clear sentence, the right code, no crash, no large allocation.
#include <gmock/gmock.h>

#include <fstream>

#include "base/stopwatch.h"
#include "raster/test_rasters.h"

namespace terray {
namespace {

using test::RasterRecipe;
using testing::HasSubstr;

class DemBadInputTest : public test::RasterTest {
protected:
    std::string writeText(const std::string& name, const std::string& text) const {
        std::ofstream(path(name), std::ios::binary) << text;
        return path(name);
    }

    void expectRefused(const std::string& file, const std::string& part,
                       const OpenOptions& options = {}, ErrorCode code = ErrorCode::Input) {
        SCOPED_TRACE(file);
        testing::internal::CaptureStderr();
        const Error error = failure(file, options);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "");  // GDAL's words are in ours
        EXPECT_EQ(error.code, code);
        EXPECT_THAT(error.message, HasSubstr(part));
        EXPECT_EQ(error.message.find('\n'), std::string::npos);
    }
};

TEST_F(DemBadInputTest, NamesThatAreNoRasters) {
    expectRefused(path("missing.tif"), "missing.tif' does not exist");
    expectRefused(folder_.string(), "is a folder");
    expectRefused(writeText("text.tif", "hello, I am a letter\n"), "cannot be opened as a raster");
    expectRefused(writeText("empty.tif", ""), "cannot be opened as a raster");
    expectRefused("", "", {});
}

TEST_F(DemBadInputTest, FewerThanTwoByTwoSamples) {
    for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 9}, {9, 1}}) {
        RasterRecipe recipe{.columns = columns, .rows = rows};
        expectRefused(write(recipe), "at least 2 x 2");
    }
    RasterRecipe smallest{.columns = 2, .rows = 2, .values = {1, 2, 3, 4}};
    EXPECT_THAT(posts(open(write(smallest))), testing::ElementsAre(1, 2, 3, 4));
}

TEST_F(DemBadInputTest, ComplexNumbersAndPalettes) {
    RasterRecipe complex{.type = GDT_CFloat32};
    expectRefused(write(complex), "complex");
    RasterRecipe palette{.type = GDT_Byte};
    palette.finish = [](GDALDataset& dataset) {
        GDALColorTable colours;
        const GDALColorEntry red{255, 0, 0, 255};
        colours.SetColorEntry(1, &red);
        ASSERT_EQ(dataset.GetRasterBand(1)->SetColorTable(&colours), CE_None);
    };
    expectRefused(write(palette, "palette.tif"), "palette");
}

TEST_F(DemBadInputTest, BandsAndEncodingsThatTheFileHasNot) {
    OpenOptions options;
    for (const int band : {0, -1, 2}) {
        options.band = band;
        expectRefused(write({}), fmt::format("--band {}", band), options, ErrorCode::Usage);
    }
    options = {};
    options.encoding = HeightEncoding::Terrarium;
    expectRefused(write({}), "--encoding terrarium", options, ErrorCode::Usage);
}

TEST_F(DemBadInputTest, TruncatedFiles) {
    RasterRecipe recipe{.columns = 300, .rows = 300, .type = GDT_Int16};
    for (int k = 0; k < 90000; ++k) recipe.values.push_back(k * 7919 % 4001);
    for (const char* compression : {"NONE", "DEFLATE", "LZW"}) {
        recipe.creation = {std::string("COMPRESS=") + compression, "BLOCKYSIZE=16"};
        const std::string file = write(recipe);
        const auto size = std::filesystem::file_size(file);
        for (const double share : {0.9, 0.5, 0.1}) {
            std::filesystem::resize_file(file, static_cast<uintmax_t>(share * double(size)));
            const Result<Dem> dem = openDem(file, {});
            if (!dem) {
                EXPECT_EQ(dem.error().code, ErrorCode::Input) << dem.error().message;
                continue;
            }
            expectRefused(file, "cannot be read");
        }
    }
    RasterRecipe floats = recipe;
    floats.type = GDT_Float32;
    const std::string file = write(floats, "floats.tif");
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    expectRefused(file, "floats.tif' cannot be");
    RasterRecipe png = recipe;
    png.driver = "PNG";
    png.creation.clear();
    const std::string picture = write(png, "dem.png");
    std::filesystem::resize_file(picture, std::filesystem::file_size(picture) / 2);
    expectRefused(picture, "cannot be read");
    expectRefused(
        writeText("short.asc", "ncols 3\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 10\n1 2 3\n"),
        "cannot be read");
}

TEST_F(DemBadInputTest, HeadersThatLieAboutTheSize) {
    const uint64_t before = peakResidentBytes();
    const auto header = [](const char* side) {
        return fmt::format("ncols {}\nnrows {}\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n",
                           side, side);
    };
    expectRefused(writeText("lie.asc", header("100000")), "lie.asc' claims 100000 x 100000");
    expectRefused(writeText("huge.asc", header("1000000000")), "huge.asc'");
    expectRefused(writeText("huge.vrt",
                            "<VRTDataset rasterXSize=\"1000000000\" rasterYSize=\"1000000000\">"
                            "<VRTRasterBand dataType=\"Float32\" band=\"1\"/></VRTDataset>"),
                  "cannot be true");
    RasterRecipe sparse{.columns = 2, .rows = 2, .type = GDT_Byte};
    const std::string strip = path("strip.tif");
    {
        CPLStringList options;
        options.AddString("SPARSE_OK=YES");
        options.AddString("COMPRESS=DEFLATE");
        options.AddString("BLOCKYSIZE=60000");
        const DatasetHandle dataset(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
            strip.c_str(), 60000, 60000, 1, GDT_Byte, options.List()));
        ASSERT_TRUE(dataset);
    }
    OpenOptions options;
    options.memoryBytes = uint64_t{1} << 30;
    const Error error = failure(strip, options);
    EXPECT_EQ(error.code, ErrorCode::Input) << error.message;
    EXPECT_LT(peakResidentBytes() - before, uint64_t{256} << 20);
}

TEST_F(DemBadInputTest, GeotransformsAndScalesThatMakeNoMap) {
    RasterRecipe flat{};
    flat.transform = {0, 1, 1, 0, 1, 1};
    expectRefused(write(flat), "without an area");
    RasterRecipe scaled{};
    scaled.scale = 0;
    expectRefused(write(scaled, "scaled.tif"), "scale");
}

TEST_F(DemBadInputTest, AVrtWhoseSourceIsGoneFailsWhenRead) {
    const std::string text =
        "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><GeoTransform>500000,1,0,4000000,0,-1"
        "</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
        "<SourceFilename relativeToVRT=\"1\">gone.tif</SourceFilename><SourceBand>1</SourceBand>"
        "</SimpleSource></VRTRasterBand></VRTDataset>";
    expectRefused(writeText("gone.vrt", text), "gone.tif");
}

TEST_F(DemBadInputTest, AContainerOfSeveralRastersListsThem) {
    const std::string file = path("two.nc");
    {
        GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("netCDF");
        const DatasetHandle dataset(driver->CreateMultiDimensional(file.c_str(), nullptr, nullptr));
        ASSERT_TRUE(dataset);
        const auto group = dataset->GetRootGroup();
        const auto y = group->CreateDimension("y", "", "", 4, nullptr);
        const auto x = group->CreateDimension("x", "", "", 5, nullptr);
        for (const char* name : {"ground", "canopy"}) {
            ASSERT_TRUE(group->CreateMDArray(name, {y, x},
                                             GDALExtendedDataType::Create(GDT_Float32), nullptr));
        }
    }
    const Error error = failure(file);
    EXPECT_EQ(error.code, ErrorCode::Input);
    EXPECT_THAT(error.message, HasSubstr("ground"));
    EXPECT_THAT(error.message, HasSubstr("canopy"));
}

}  // namespace
}  // namespace terray
