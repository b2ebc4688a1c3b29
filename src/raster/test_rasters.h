// SPDX-License-Identifier: Apache-2.0
// Small rasters for tests, written by GDAL into a folder that goes with the test.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dataset/gdal_handle.h"
#include "raster/dem.h"

namespace terray::test {

inline std::vector<std::string> textsOf(const SourceInfo& facts) {
    std::vector<std::string> texts;
    for (const Assumption& assumption : facts.assumptions) texts.push_back(assumption.text);
    return texts;
}

/// What to write; values row by row.
struct RasterRecipe {
    int columns = 4, rows = 3, bands = 1;
    GDALDataType type = GDT_Float32;
    std::vector<double> values = {};  ///< of band 1 (all bands one after the other if more)
    std::optional<std::array<double, 6>> transform = std::array<double, 6>{5e5, 10, 0, 4e6, 0, -10};
    std::string crs = "EPSG:32633";
    std::optional<double> nodata = {}, scale = {}, offset = {};
    std::string unit = {};
    std::string driver = "GTiff";
    std::vector<std::string> creation = {};                   ///< "KEY=VALUE"
    std::function<void(GDALDataset&)> finish = [](auto&) {};  ///< masks, palettes, metadata
};

class RasterTest : public testing::Test {
protected:
    RasterTest() {
        ensureGdal();
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  fmt::format("terray-{}-{}-{}", info->test_suite_name(), info->name(), getpid());
        std::filesystem::create_directories(folder_);
    }
    ~RasterTest() override { std::filesystem::remove_all(folder_); }

    std::string path(const std::string& name) const { return (folder_ / name).string(); }

    static void setCrs(GDALDataset& dataset, const std::string& crs) {
        OGRSpatialReference reference;
        ASSERT_EQ(reference.SetFromUserInput(crs.c_str()), OGRERR_NONE);
        reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        ASSERT_EQ(dataset.SetSpatialRef(&reference), CE_None);
    }

    static void fillBands(GDALDataset& dataset, const RasterRecipe& recipe) {
        const auto count = static_cast<size_t>(recipe.columns) * static_cast<size_t>(recipe.rows);
        std::vector<double> values = recipe.values;
        values.resize(count * static_cast<size_t>(recipe.bands));
        for (int b = 0; b < recipe.bands; ++b) {
            GDALRasterBand& band = *dataset.GetRasterBand(b + 1);
            if (recipe.nodata) band.SetNoDataValue(*recipe.nodata);
            if (recipe.scale) band.SetScale(*recipe.scale);
            if (recipe.offset) band.SetOffset(*recipe.offset);
            if (!recipe.unit.empty()) band.SetUnitType(recipe.unit.c_str());
            ASSERT_EQ(band.RasterIO(GF_Write, 0, 0, recipe.columns, recipe.rows,
                                    values.data() + count * static_cast<size_t>(b), recipe.columns,
                                    recipe.rows, GDT_Float64, 0, 0, nullptr),
                      CE_None);
        }
    }

    /// Writes the raster and answers with its path. Drivers that cannot create are copied to.
    std::string write(const RasterRecipe& recipe, const std::string& name = "dem.tif") const {
        const std::string file = path(name);
        GDALDriverManager& manager = *GetGDALDriverManager();
        GDALDriver* driver = manager.GetDriverByName(recipe.driver.c_str());
        const bool creates = driver->GetMetadataItem(GDAL_DCAP_CREATE) != nullptr;
        CPLStringList options;
        for (const std::string& option : recipe.creation) options.AddString(option.c_str());
        GDALDriver* maker = creates ? driver : manager.GetDriverByName("MEM");
        DatasetHandle dataset(maker->Create(file.c_str(), recipe.columns, recipe.rows, recipe.bands,
                                            recipe.type, creates ? options.List() : nullptr));
        EXPECT_TRUE(dataset) << gdalMessage();
        std::array<double, 6> transform = recipe.transform.value_or(std::array<double, 6>{});
        if (recipe.transform) dataset->SetGeoTransform(transform.data());
        if (!recipe.crs.empty()) setCrs(*dataset, recipe.crs);
        recipe.finish(*dataset);
        fillBands(*dataset, recipe);
        if (!creates) {
            DatasetHandle(driver->CreateCopy(file.c_str(), dataset.get(), FALSE, options.List(),
                                             nullptr, nullptr));
        }
        return file;
    }

    /// Opens; a failure is a test failure with the sentence.
    static Dem open(const std::string& file, const OpenOptions& options = {}) {
        Result<Dem> dem = openDem(file, options);
        if (!dem) {
            ADD_FAILURE() << dem.error().message;
            return {};
        }
        return std::move(*dem);
    }

    /// All posts, read at once.
    static std::vector<float> posts(const Dem& dem) {
        if (!dem.source) return {};
        const TilingScheme& scheme = dem.source->info().scheme;
        std::vector<float> heights(static_cast<size_t>(scheme.columns * scheme.rows));
        Result<std::unique_ptr<HeightReader>> reader = dem.source->makeReader();
        EXPECT_TRUE(reader);
        const Result<void> done = (*reader)->read(0, 0, scheme.columns, scheme.rows, heights);
        EXPECT_TRUE(done) << done.error().message;
        return heights;
    }

    /// The error of opening, or of reading all posts if it opens.
    static Error failure(const std::string& file, const OpenOptions& options = {}) {
        Result<Dem> dem = openDem(file, options);
        if (!dem) return dem.error();
        const TilingScheme& scheme = dem->source->info().scheme;
        std::vector<float> heights(static_cast<size_t>(scheme.columns * scheme.rows));
        Result<std::unique_ptr<HeightReader>> reader = dem->source->makeReader();
        if (!reader) return reader.error();
        const Result<void> done = (*reader)->read(0, 0, scheme.columns, scheme.rows, heights);
        if (!done) return done.error();
        ADD_FAILURE() << file << " was accepted";
        return {};
    }

    static SourceInfo scanned(const std::string& file, const OpenOptions& options = {}) {
        SourceInfo facts = open(file, options).facts;
        const Result<void> done = scanDem(file, options, facts);
        EXPECT_TRUE(done) << done.error().message;
        return facts;
    }

    std::filesystem::path folder_;
};

}  // namespace terray::test
