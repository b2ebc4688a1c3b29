// SPDX-License-Identifier: Apache-2.0
// Tests of what samples become: types, scales, holes, units, encodings, 16-bit codes.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <random>

#include "raster/test_rasters.h"

namespace terray {
namespace {

using test::RasterRecipe;
using test::textsOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::NanSensitiveFloatEq;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class DemTest : public test::RasterTest {
protected:
    static std::vector<uint16_t> codes(const Dem& dem) {
        const TilingScheme& scheme = dem.source->info().scheme;
        std::vector<uint16_t> out(static_cast<size_t>(scheme.columns * scheme.rows));
        Result<std::unique_ptr<HeightReader>> reader = dem.source->makeReader();
        const Result<void> done = (*reader)->readCodes(0, 0, scheme.columns, scheme.rows, out);
        EXPECT_TRUE(done) << done.error().message;
        return out;
    }

    /// Kernels decode codes with one fused operation; it must give the very floats of read().
    static void expectCodesAreHeights(const Dem& dem) {
        const TerrainInfo& info = dem.source->info();
        ASSERT_EQ(info.format, PostFormat::Int16);
        ASSERT_GT(info.zStep, 0);
        const std::vector<float> heights = posts(dem);
        const std::vector<uint16_t> all = codes(dem);
        for (size_t k = 0; k < all.size(); ++k) {
            const float decoded = all[k] == kHolePost
                                      ? kNan
                                      : std::fma(info.zStep, static_cast<float>(all[k]), info.z0);
            EXPECT_THAT(decoded, NanSensitiveFloatEq(heights[k])) << k;
        }
    }
};

std::vector<double> randomIntegers(size_t count, int lowest, int highest, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> draw(lowest, highest);
    std::vector<double> values(count);
    for (double& value : values) value = draw(random);
    values.front() = lowest;
    values.back() = highest;
    return values;
}

struct TypeCase {
    GDALDataType type;
    int lowest, highest;
    PostFormat format;
    const char* name;
};

TEST_F(DemTest, EveryRealTypeIsReadExactly) {
    const TypeCase cases[] = {
        {GDT_Byte, 0, 255, PostFormat::Int16, "Byte"},
        {GDT_Int16, -430, 8848, PostFormat::Int16, "Int16"},
        {GDT_Int16, -32768, 32766, PostFormat::Int16, "Int16"},
        {GDT_Int16, -32768, 32767, PostFormat::Float32, "Int16"},
        {GDT_UInt16, 0, 65534, PostFormat::Int16, "UInt16"},
        {GDT_UInt16, 0, 65535, PostFormat::Float32, "UInt16"},
        {GDT_Int32, -5000000, -4990000, PostFormat::Int16, "Int32"},
        {GDT_Int32, -70000, 70000, PostFormat::Float32, "Int32"},
        {GDT_UInt32, 7, 4000, PostFormat::Int16, "UInt32"},
        {GDT_Int64, -100, 4000, PostFormat::Int16, "Int64"},
        {GDT_Float32, -430, 8848, PostFormat::Float32, "Float32"},
        {GDT_Float64, -430, 8848, PostFormat::Float32, "Float64"},
    };
    for (const TypeCase& c : cases) {
        SCOPED_TRACE(fmt::format("{} {} {}", c.name, c.lowest, c.highest));
        RasterRecipe recipe{.columns = 37, .rows = 23, .type = c.type};
        recipe.values = randomIntegers(37 * 23, c.lowest, c.highest, 7);
        const Dem dem = open(write(recipe));
        EXPECT_EQ(dem.facts.sampleType, c.name);
        EXPECT_EQ(dem.source->info().format, c.format);
        const std::vector<float> heights = posts(dem);
        for (size_t k = 0; k < heights.size(); ++k) {
            ASSERT_EQ(heights[k], static_cast<float>(recipe.values[k])) << k;
        }
        if (c.format == PostFormat::Int16) expectCodesAreHeights(dem);
    }
}

TEST_F(DemTest, SignedBytesAreSigned) {
    RasterRecipe recipe{.columns = 4, .rows = 2, .type = GDT_Byte};
    recipe.creation = {"PIXELTYPE=SIGNEDBYTE"};
    recipe.values = {0, 1, 127, 128, 255, 200, 5, 6};  // as the bytes stand in the file
    recipe.nodata = -1;
    const Dem dem = open(write(recipe));
    EXPECT_EQ(dem.facts.sampleType, "Int8");
    EXPECT_THAT(posts(dem), ElementsAre(0, 1, 127, -128, NanSensitiveFloatEq(kNan), -56, 5, 6));
    expectCodesAreHeights(dem);
}

TEST_F(DemTest, ScaleAndOffsetApplyAndKeepSixteenBits) {
    for (const double scale : {0.25, 0.1, 1.0 / 3}) {
        RasterRecipe recipe{.columns = 40, .rows = 30, .type = GDT_UInt16};
        recipe.values = randomIntegers(1200, 0, 40000, 11);
        recipe.scale = scale;
        recipe.offset = -500;
        const Dem dem = open(write(recipe));
        EXPECT_EQ(dem.facts.scale, scale);
        EXPECT_EQ(dem.facts.offset, -500);
        expectCodesAreHeights(dem);
        const std::vector<float> heights = posts(dem);
        for (size_t k = 0; k < heights.size(); ++k) {
            const double exact = recipe.values[k] * scale - 500;
            // 0.25 is a power of two: one rounding; else the step itself is rounded: one more ulp
            const double slack = scale == 0.25 ? 0 : 0.001;
            ASSERT_NEAR(heights[k], static_cast<float>(exact), slack);
        }
    }
}

TEST_F(DemTest, NegativeScaleIsReadAsFloats) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .type = GDT_Int16, .values = {0, 1, 2, 10}};
    recipe.scale = -2;
    const Dem dem = open(write(recipe));
    EXPECT_EQ(dem.source->info().format, PostFormat::Float32);
    EXPECT_THAT(posts(dem), ElementsAre(0, -2, -4, -20));
    EXPECT_EQ(dem.facts.minHeight, -20);
}

TEST_F(DemTest, CodesLeaveRoomForFractionsOfCoarserMips) {
    RasterRecipe recipe{.columns = 3, .rows = 2, .type = GDT_Int16};
    recipe.values = {263, 4371, 1000, 2000, 3000, -32768};
    recipe.nodata = -32768;
    const Dem dem = open(write(recipe));
    EXPECT_EQ(dem.source->info().zStep, 0.125F);  // 4108 metres in 65535 codes
    expectCodesAreHeights(dem);
    EXPECT_EQ(codes(dem).back(), kHolePost);
    EXPECT_TRUE(dem.facts.hasRange);
    EXPECT_EQ(dem.facts.minHeight, 263);
    EXPECT_EQ(dem.facts.maxHeight, 4371);
    EXPECT_EQ(dem.facts.holes, 1);
}

struct NodataCase {
    GDALDataType type;
    double declared, stored;
    const char* rule;
};

TEST_F(DemTest, NodataValuesAreHoles) {
    constexpr double kFloatMax = std::numeric_limits<float>::max();
    const NodataCase cases[] = {
        {GDT_Int16, -32768, -32768, "value -32768"},
        {GDT_Byte, 255, 255, "value 255"},
        {GDT_UInt16, 0, 0, "value 0"},
        {GDT_Int32, -2147483648.0, -2147483648.0, "value -2147483648"},
        {GDT_Float32, -9999, -9999, "value -9999"},
        {GDT_Float32, -3.4e38, -3.4e38, "value"},
        {GDT_Float32, -3.4028235e38, -kFloatMax, "value"},
        {GDT_Float32, -3.4e38, -kFloatMax, "value"},  // declared carelessly
        {GDT_Float64, -3.40282346638529e+38, -kFloatMax, "value"},
        {GDT_Float32, std::nan(""), std::nan(""), "NaN"},
        {GDT_Float64, 0.1, 0.1, "value 0.1"},
        {GDT_Float64, 0.1, std::nextafter(0.1, 1.0), "value 0.1"},  // a text round trip away
    };
    for (const NodataCase& c : cases) {
        SCOPED_TRACE(fmt::format("{} {}", GDALGetDataTypeName(c.type), c.declared));
        RasterRecipe recipe{.columns = 3, .rows = 2, .type = c.type};
        recipe.values = {1, 2, c.stored, 4, 5, 6};
        recipe.nodata = c.declared;
        const std::string file = write(recipe);
        const Dem dem = open(file);
        EXPECT_THAT(dem.facts.nodataRule, HasSubstr(c.rule));
        EXPECT_THAT(posts(dem), ElementsAre(1, 2, NanSensitiveFloatEq(kNan), 4, 5, 6));
        const SourceInfo facts = scanned(file);
        EXPECT_EQ(facts.holes, 1);
        EXPECT_EQ(facts.minHeight, 1);
        EXPECT_EQ(facts.maxHeight, 6);
    }
}

TEST_F(DemTest, NanInfinityAndFillValuesAreHolesEvenUndeclared) {
    RasterRecipe recipe{.columns = 4, .rows = 2, .type = GDT_Float32};
    recipe.values = {1, HUGE_VAL, -HUGE_VAL, std::nan(""), 1e-42, 9000, 9.96921e36, -1.70141e38};
    const std::string file = write(recipe);
    const auto hole = NanSensitiveFloatEq(kNan);
    EXPECT_THAT(posts(open(file)), ElementsAre(1, hole, hole, hole, 1e-42F, 9000, hole, hole));
    EXPECT_EQ(scanned(file).nodataRule, "none");
}

TEST_F(DemTest, GivenNodataReplacesTheDeclaredOne) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .type = GDT_Int16, .values = {0, 7, -9, 3}};
    recipe.nodata = -9;
    OpenOptions options;
    options.nodata = 0;
    const Dem dem = open(write(recipe), options);
    EXPECT_THAT(posts(dem), ElementsAre(NanSensitiveFloatEq(kNan), 7, -9, 3));
    EXPECT_EQ(dem.facts.nodataRule, "value 0 (--nodata)");
}

TEST_F(DemTest, AllHolesIsATerrainWithoutHeights) {
    for (const GDALDataType type : {GDT_Int16, GDT_Float32}) {
        RasterRecipe recipe{.columns = 2, .rows = 2, .type = type, .values = {-9, -9, -9, -9}};
        recipe.nodata = -9;
        const std::string file = write(recipe);
        const SourceInfo facts = scanned(file);
        EXPECT_TRUE(facts.hasRange);
        EXPECT_GT(facts.minHeight, facts.maxHeight);
        EXPECT_EQ(facts.holes, 4);
        for (const float z : posts(open(file))) EXPECT_TRUE(std::isnan(z));
    }
}

TEST_F(DemTest, MaskAndAlphaBandsMarkHoles) {
    std::vector<uint8_t> mask{255, 0, 255, 255, 255, 0};
    RasterRecipe masked{.columns = 3, .rows = 2, .type = GDT_Int16, .values = {1, 2, 3, 4, 5, 6}};
    masked.finish = [&](GDALDataset& dataset) {
        ASSERT_EQ(dataset.CreateMaskBand(GMF_PER_DATASET), CE_None);
        ASSERT_EQ(dataset.GetRasterBand(1)->GetMaskBand()->RasterIO(
                      GF_Write, 0, 0, 3, 2, mask.data(), 3, 2, GDT_Byte, 0, 0, nullptr),
                  CE_None);
    };
    const Dem dem = open(write(masked));
    EXPECT_EQ(dem.facts.nodataRule, "mask band");
    EXPECT_THAT(posts(dem),
                ElementsAre(1, NanSensitiveFloatEq(kNan), 3, 4, 5, NanSensitiveFloatEq(kNan)));
    expectCodesAreHeights(dem);

    RasterRecipe alpha{.columns = 2, .rows = 2, .bands = 2, .type = GDT_UInt16};
    alpha.values = {10, 20, 30, 40, 65535, 65535, 0, 65535};
    alpha.creation = {"ALPHA=YES"};
    const Dem seen = open(write(alpha, "alpha.tif"));
    EXPECT_EQ(seen.facts.nodataRule, "alpha band");
    EXPECT_THAT(posts(seen), ElementsAre(10, 20, NanSensitiveFloatEq(kNan), 40));
}

TEST_F(DemTest, UndeclaredSentinelsAreHeightsButToldOf) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .type = GDT_Int16};
    recipe.values = {100, 200, -32768, 300};
    const Dem dem = open(write(recipe));
    EXPECT_THAT(posts(dem), ElementsAre(100, 200, -32768, 300));
    EXPECT_THAT(textsOf(dem.facts), testing::Contains(HasSubstr("--nodata -32768")));
}

TEST_F(DemTest, FeetBecomeMetres) {
    struct Case {
        const char* unit;
        std::optional<HeightUnit> given;
        double metres;
        const char* name;
    };
    const Case cases[] = {
        {"ft", {}, 0.3048, "ft"},
        {"US survey foot", {}, 1200.0 / 3937, "us-ft"},
        {"metre", {}, 1, "m"},
        {"m", HeightUnit::Foot, 0.3048, "ft"},
        {"", HeightUnit::UsSurveyFoot, 1200.0 / 3937, "us-ft"},
    };
    for (const Case& c : cases) {
        for (const GDALDataType type : {GDT_Float32, GDT_Int16, GDT_Float64}) {
            SCOPED_TRACE(fmt::format("'{}' {}", c.unit, GDALGetDataTypeName(type)));
            RasterRecipe recipe{.columns = 2, .rows = 2, .type = type};
            recipe.values = {0, 1000, 2231, 14410};
            recipe.unit = c.unit;
            OpenOptions options;
            options.heightUnit = c.given;
            const std::string file = write(recipe);
            const Dem dem = open(file, options);
            EXPECT_EQ(dem.facts.heightUnit, c.name);
            EXPECT_THAT(textsOf(dem.facts), IsEmpty());
            const std::vector<float> heights = posts(dem);
            for (size_t k = 0; k < 4; ++k) {
                EXPECT_NEAR(heights[k], recipe.values[k] * c.metres, 5e-4) << k;
            }
            EXPECT_DOUBLE_EQ(scanned(file, options).maxHeight, 14410 * c.metres);
        }
    }
}

TEST_F(DemTest, UnknownHeightUnitIsAssumedAndSaid) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .values = {1, 2, 3, 4}};
    EXPECT_THAT(textsOf(open(write(recipe)).facts),
                ElementsAre(HasSubstr("metres are assumed (--height-unit")));
    recipe.unit = "furlong";
    EXPECT_THAT(textsOf(open(write(recipe)).facts), ElementsAre(HasSubstr("'furlong'")));
}

TEST_F(DemTest, EncodedHeightsAreDecoded) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .bands = 4, .type = GDT_Byte};
    recipe.driver = "PNG";
    // red, green, blue, alpha of four pixels
    recipe.values = {1, 0, 2, 1, 134, 0, 3, 134, 160, 0, 4, 160, 255, 255, 255, 0};
    const std::string file = write(recipe, "tile.png");
    OpenOptions options;
    options.encoding = HeightEncoding::TerrainRgb;
    const Dem mapbox = open(file, options);
    EXPECT_THAT(posts(mapbox),
                ElementsAre(static_cast<float>(-10000 + 0.1 * (65536 + 134 * 256 + 160)), -10000,
                            static_cast<float>(-10000 + 0.1 * (2 * 65536 + 3 * 256 + 4)),
                            NanSensitiveFloatEq(kNan)));
    EXPECT_EQ(mapbox.source->info().format, PostFormat::Float32);
    options.encoding = HeightEncoding::Terrarium;
    EXPECT_THAT(posts(open(file, options)),
                ElementsAre(256 + 134 + 160 / 256.0F - 32768, -32768, 512 + 3 + 4 / 256.0F - 32768,
                            NanSensitiveFloatEq(kNan)));
}

TEST_F(DemTest, AnEncodedPictureIsRecognisedAndTheFlagNamed) {
    RasterRecipe recipe{.columns = 16, .rows = 16, .bands = 3, .type = GDT_Byte};
    recipe.driver = "PNG";
    for (int k = 0; k < 256; ++k) recipe.values.push_back(1);
    for (int k = 0; k < 256; ++k) recipe.values.push_back(200 + k / 64);
    for (int k = 0; k < 256; ++k) recipe.values.push_back(k * 37 % 256);
    const Dem dem = open(write(recipe, "tile.png"));
    EXPECT_THAT(textsOf(dem.facts), testing::Contains(HasSubstr("--encoding terrain-rgb")));
}

TEST_F(DemTest, AnyWindowReadsTheSameHeightsWhateverTheBlocks) {
    const std::vector<std::vector<std::string>> layouts{
        {}, {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32"}, {"BLOCKYSIZE=7", "COMPRESS=DEFLATE"}};
    for (const auto& layout : layouts) {
        for (const GDALDataType type : {GDT_Int16, GDT_Float64}) {
            RasterRecipe recipe{.columns = 131, .rows = 67, .type = type, .creation = layout};
            recipe.values = randomIntegers(131 * 67, -100, 4000, 3);
            const Dem dem = open(write(recipe));
            EXPECT_GE(dem.source->preferredRows(), 64);
            EXPECT_LE(dem.source->preferredRows(), 513);
            Result<std::unique_ptr<HeightReader>> reader = dem.source->makeReader();
            std::vector<float> part(40 * 21);
            ASSERT_TRUE((*reader)->read(77, 31, 40, 21, part));
            for (size_t j = 0; j < 21; ++j) {
                for (size_t i = 0; i < 40; ++i) {
                    ASSERT_EQ(part[j * 40 + i], recipe.values[(31 + j) * 131 + 77 + i]);
                }
            }
        }
    }
}

TEST_F(DemTest, BandsAreChosenByNumber) {
    RasterRecipe recipe{.columns = 2, .rows = 2, .bands = 2, .values = {1, 2, 3, 4, 5, 6, 7, 8}};
    OpenOptions options;
    options.band = 2;
    EXPECT_THAT(posts(open(write(recipe), options)), ElementsAre(5, 6, 7, 8));
}

TEST_F(DemTest, SyntheticNamesOpenWithFacts) {
    const Dem dem = open("synthetic:fractal?size=64&cell=10&seed=1");
    EXPECT_EQ(dem.facts.driver, "synthetic");
    EXPECT_EQ(dem.facts.columns, dem.source->info().scheme.columns);
    EXPECT_EQ(dem.facts.pixelWidth, 10);
    const SourceInfo facts = scanned("synthetic:fractal?size=64&cell=10&seed=1");
    EXPECT_TRUE(facts.hasRange);
    EXPECT_GT(facts.maxHeight, facts.minHeight);
}

}  // namespace
}  // namespace terray
