// SPDX-License-Identifier: Apache-2.0
// Bounds as TIFF bands and back.
#include "store/bounds_file.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <ogr_spatialref.h>

#include <array>
#include <bit>
#include <cmath>

#include "base/assert.h"
#include "dataset/gdal_handle.h"
#include "store/gdal_scope.h"

namespace terray {
namespace {

constexpr std::array<const char*, kBoundsBands> kBandNames{
    "minimum", "maximum",    "error to mip 0", "error to the next mip",
    "slope",   "cell range", "coverage error", "flags"};
constexpr int kSide = 256;  ///< of a TIFF block

float valueOf(const BlockBounds& b, int band) {
    const std::array<float, kBoundsBands> values{
        b.minZ,     b.maxZ,      b.errorToFinest, b.errorToNext,
        b.maxSlope, b.cellRange, b.coverageError, static_cast<float>(b.flags)};
    return values[static_cast<size_t>(band)];
}

void setValue(BlockBounds& b, int band, float value) {
    float* const fields[] = {&b.minZ,     &b.maxZ,      &b.errorToFinest, &b.errorToNext,
                             &b.maxSlope, &b.cellRange, &b.coverageError};
    if (band < kBoundsBands - 1) {
        *fields[band] = value;
    } else {
        b.flags = static_cast<uint32_t>(value);
    }
}

Error encodeError(int mip) {
    return makeError(ErrorCode::Failed, "GDAL cannot encode '{}': {}", boundsPath(mip),
                     gdalMessage());
}

/// Pixels are the blocks: 64 cells a side, from the first post on.
bool place(GDALDataset& dataset, const TerrainInfo& info, int mip) {
    const double unit = 1 / info.metresPerCrsUnit, cells = std::ldexp(1.0 * kBlockCells, mip);
    const Affine2& map = info.worldFromLattice;
    const Vec2 origin = unit * map.origin, x = unit * cells * map.column,
               y = unit * cells * map.row;
    double transform[6] = {origin.x, x.x, y.x, origin.y, x.y, y.y};
    if (dataset.SetGeoTransform(transform) != CE_None) return false;
    if (info.crsWkt.empty()) return true;
    OGRSpatialReference crs;
    if (crs.importFromWkt(info.crsWkt.c_str()) != OGRERR_NONE) return false;
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return dataset.SetSpatialRef(&crs) == CE_None;
}

bool writeBlocks(GDALRasterBand& band, int number, int width, int height,
                 std::span<const BlockBounds> bounds) {
    std::vector<float> block(size_t{kSide} * kSide);
    for (int y = 0; y * kSide < height; ++y) {
        for (int x = 0; x * kSide < width; ++x) {
            for (int j = 0; j < kSide; ++j) {
                for (int i = 0; i < kSide; ++i) {
                    const int column = std::min(x * kSide + i, width - 1);
                    const int row = std::min(y * kSide + j, height - 1);
                    const auto k = static_cast<size_t>(int64_t{row} * width + column);
                    block[static_cast<size_t>(j * kSide + i)] = valueOf(bounds[k], number);
                }
            }
            if (band.WriteBlock(x, y, block.data()) != CE_None) return false;
        }
    }
    return true;
}

}  // namespace

Result<EncodedFile> encodeBounds(const TerrainInfo& info, int mip,
                                 std::span<const BlockBounds> bounds) {
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    const int width = boundsX(info.scheme, mip), height = boundsY(info.scheme, mip);
    TERRAY_ASSERT(bounds.size() == static_cast<size_t>(int64_t{width} * height));
    CPLStringList options;
    for (const char* option : {"TILED=YES", "BLOCKXSIZE=256", "BLOCKYSIZE=256", "COMPRESS=ZSTD",
                               "PREDICTOR=3", "INTERLEAVE=BAND", "BIGTIFF=IF_SAFER"}) {
        options.AddString(option);
    }
    const std::string name = memoryFileName();
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    DatasetHandle dataset(
        driver->Create(name.c_str(), width, height, kBoundsBands, GDT_Float32, options.List()));
    bool good = dataset && place(*dataset, info, mip);
    for (int k = 0; good && k < kBoundsBands; ++k) {
        dataset->GetRasterBand(k + 1)->SetDescription(kBandNames[static_cast<size_t>(k)]);
    }
    for (int k = 0; good && k < kBoundsBands; ++k) {
        good = writeBlocks(*dataset->GetRasterBand(k + 1), k, width, height, bounds);
    }
    dataset.reset();
    EncodedFile file;
    vsi_l_offset size = 0;
    const auto* bytes =
        reinterpret_cast<const std::byte*>(VSIGetMemFileBuffer(name.c_str(), &size, FALSE));
    if (good && bytes != nullptr) file.bytes.assign(bytes, bytes + size);
    VSIUnlink(name.c_str());
    if (file.bytes.empty()) return encodeError(mip);
    return file;
}

Result<std::vector<BlockBounds>> readBounds(const std::string& name,
                                            std::span<const std::byte> bytes,
                                            const TerrainInfo& info, int mip) {
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    struct MemoryFile {
        std::string path = memoryFileName();
        ~MemoryFile() { VSIUnlink(path.c_str()); }
    } memory;
    auto* data = reinterpret_cast<GByte*>(const_cast<std::byte*>(bytes.data()));
    VSIFCloseL(VSIFileFromMemBuffer(memory.path.c_str(), data, bytes.size(), FALSE));
    static const char* const kDrivers[] = {"GTiff", nullptr};
    const DatasetHandle dataset(
        GDALDataset::Open(memory.path.c_str(), GDAL_OF_RASTER | GDAL_OF_INTERNAL, kDrivers));
    if (!dataset) {
        return makeError(ErrorCode::Input, "'{}' cannot be opened: {}", name, gdalMessage());
    }
    const int width = boundsX(info.scheme, mip), height = boundsY(info.scheme, mip);
    if (dataset->GetRasterXSize() != width || dataset->GetRasterYSize() != height ||
        dataset->GetRasterCount() != kBoundsBands) {
        return makeError(ErrorCode::Input,
                         "'{}' is not the bounds file that the store says: it should have {} x {} "
                         "pixels in {} bands",
                         name, width, height, kBoundsBands);
    }
    std::vector<BlockBounds> bounds(static_cast<size_t>(int64_t{width} * height));
    std::vector<float> row(static_cast<size_t>(width));
    for (int band = 0; band < kBoundsBands; ++band) {
        for (int y = 0; y < height; ++y) {
            if (dataset->GetRasterBand(band + 1)->RasterIO(GF_Read, 0, y, width, 1, row.data(),
                                                           width, 1, GDT_Float32, 0, 0,
                                                           nullptr) != CE_None) {
                return makeError(ErrorCode::Input, "'{}' cannot be read: {}", name, gdalMessage());
            }
            BlockBounds* out = bounds.data() + int64_t{y} * width;
            for (int x = 0; x < width; ++x) setValue(out[x], band, row[static_cast<size_t>(x)]);
        }
    }
    return bounds;
}

}  // namespace terray
