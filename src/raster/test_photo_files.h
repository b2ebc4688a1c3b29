// SPDX-License-Identifier: Apache-2.0
// Small rasters for the photo tests: written with GDAL into the test's temporary folder.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "dataset/gdal_handle.h"

namespace terray {

struct TestRaster {
    int width = 0, height = 0, bands = 3;
    GDALDataType type = GDT_Byte;
    std::string crs = {};                               ///< "EPSG:n"; empty: none
    std::array<double, 6> transform{0, 1, 0, 0, 0, 1};  ///< identity: no georeference
    std::function<double(int band, int i, int j)> value;
    std::function<void(GDALDataset&)> finish = [](GDALDataset&) {};
};

/// Writes a GeoTIFF and gives its path.
inline std::string writeRaster(const std::string& name, const TestRaster& raster) {
    ensureGdal();
    const std::string path = testing::TempDir() + name;
    GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const char* const options[] = {"PHOTOMETRIC=MINISBLACK", nullptr};
    const bool isColour = raster.bands == 3 && raster.type == GDT_Byte;
    DatasetHandle dataset(driver->Create(path.c_str(), raster.width, raster.height, raster.bands,
                                         raster.type,
                                         isColour ? nullptr : const_cast<char**>(options)));
    std::array<double, 6> transform = raster.transform;
    if (transform != TestRaster{}.transform) dataset->SetGeoTransform(transform.data());
    if (!raster.crs.empty()) {
        OGRSpatialReference reference;
        reference.SetFromUserInput(raster.crs.c_str());
        dataset->SetSpatialRef(&reference);
    }
    raster.finish(*dataset);
    std::vector<double> values(static_cast<size_t>(raster.width) *
                               static_cast<size_t>(raster.height));
    for (int band = 1; band <= raster.bands; ++band) {
        size_t k = 0;
        for (int j = 0; j < raster.height; ++j) {
            for (int i = 0; i < raster.width; ++i) values[k++] = raster.value(band, i, j);
        }
        EXPECT_EQ(dataset->GetRasterBand(band)->RasterIO(GF_Write, 0, 0, raster.width,
                                                         raster.height, values.data(), raster.width,
                                                         raster.height, GDT_Float64, 0, 0, nullptr),
                  CE_None);
    }
    return path;
}

}  // namespace terray
