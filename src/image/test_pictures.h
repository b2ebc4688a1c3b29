// SPDX-License-Identifier: Apache-2.0
// What the writer tests share: seeded pictures, a scratch folder, GDAL as the reader.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "image/writer.h"

namespace terray {

/// A folder of its own for each test, removed afterwards.
class ScratchFolder : public testing::Test {
protected:
    void SetUp() override {
        GDALAllRegister();
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        std::string name = std::string(info->test_suite_name()) + "_" + info->name();
        for (char& c : name) c = c == '/' ? '_' : c;
        folder_ = testing::TempDir() + name;
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::string at(const std::string& name) const { return folder_ + "/" + name; }
    std::vector<std::string> names() const {
        std::vector<std::string> found;
        for (const auto& entry : std::filesystem::directory_iterator(folder_))
            found.push_back(entry.path().filename().string());
        return found;
    }
    std::string folder_;
};

/// Smooth colours with some noise, as pictures have.
template <class T>
std::vector<T> seededPixels(const ImageSpec& spec, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<T> pixels(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) *
                          static_cast<size_t>(spec.channels));
    for (size_t k = 0; k < pixels.size(); ++k) {
        const double wave = 100 + 80 * std::sin(static_cast<double>(k) * 1e-3);
        const double value = wave + static_cast<double>(random() % 20);
        if constexpr (std::is_same_v<T, float>) {
            pixels[k] = static_cast<float>(value * 1.37 - 50);
        } else {
            pixels[k] = static_cast<T>(value);
        }
    }
    return pixels;
}

/// Writes in bands of the given number of rows.
template <class T>
Result<void> writePicture(const std::string& path, const ImageSpec& spec,
                          const std::vector<T>& pixels, int bandRows) {
    Result<std::unique_ptr<ImageWriter>> writer = makeImageWriter(path, spec);
    if (!writer) return writer.error();
    const size_t row = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.channels);
    for (int y = 0; y < spec.height; y += bandRows) {
        const auto rows = static_cast<size_t>(std::min(bandRows, spec.height - y));
        const std::span<const T> band(pixels.data() + static_cast<size_t>(y) * row, rows * row);
        if (Result<void> done = (*writer)->writeRows(band); !done) return done.error();
    }
    return (*writer)->finish();
}

/// All pixels of a file, interleaved, as GDAL reads them.
template <class T>
std::vector<T> readPixels(const std::string& path) {
    GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
    if (!file) return {};
    const int width = file->GetRasterXSize(), height = file->GetRasterYSize();
    const int channels = file->GetRasterCount();
    std::vector<T> pixels(static_cast<size_t>(width) * static_cast<size_t>(height) *
                          static_cast<size_t>(channels));
    const GSpacing sample = sizeof(T);
    const CPLErr done =
        file->RasterIO(GF_Read, 0, 0, width, height, pixels.data(), width, height,
                       std::is_same_v<T, float> ? GDT_Float32 : GDT_Byte, channels, nullptr,
                       sample * channels, sample * channels * width, sample, nullptr);
    EXPECT_EQ(done, CE_None);
    return pixels;
}

}  // namespace terray
