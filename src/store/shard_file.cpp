// SPDX-License-Identifier: Apache-2.0
// Decoding of height files, block by block, past GDAL's block cache.
#include <cpl_vsi.h>

#include <cmath>

#include "base/assert.h"
#include "dataset/gdal_handle.h"
#include "store/gdal_scope.h"
#include "store/shard_codec.h"

namespace terray {

struct ShardFile::Handle {
    DatasetHandle dataset;
};

ShardFile::ShardFile() : handle_(std::make_unique<Handle>()) {}

ShardFile::~ShardFile() {
    handle_.reset();
    if (!memoryFile_.empty()) VSIUnlink(memoryFile_.c_str());
}

Result<std::unique_ptr<ShardFile>> ShardFile::open(const std::string& path, const TerrainInfo& info,
                                                   ShardId shard) {
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    std::unique_ptr<ShardFile> file(new ShardFile);
    file->path_ = path;
    file->shard_ = shard;
    file->format_ = info.format;
    static const char* const kDrivers[] = {"GTiff", nullptr};
    file->handle_->dataset.reset(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_INTERNAL, kDrivers));
    if (!file->handle_->dataset) {
        return makeError(ErrorCode::Input, "'{}' cannot be opened: {}", path, gdalMessage());
    }
    TERRAY_TRY(file->check(info, shard));
    return file;
}

Result<std::unique_ptr<ShardFile>> ShardFile::open(const EncodedFile& encoded,
                                                   const TerrainInfo& info, ShardId shard) {
    const std::string name = memoryFileName();
    auto* bytes = reinterpret_cast<GByte*>(const_cast<std::byte*>(encoded.bytes.data()));
    VSIFCloseL(VSIFileFromMemBuffer(name.c_str(), bytes, encoded.bytes.size(), FALSE));
    Result<std::unique_ptr<ShardFile>> file = open(name, info, shard);
    if (file) {
        (*file)->memoryFile_ = name;
    } else {
        VSIUnlink(name.c_str());
    }
    return file;
}

Result<std::unique_ptr<ShardFile>> ShardFile::openInPlace(const std::string& path,
                                                          const InPlaceSource& source,
                                                          const TerrainInfo& info, ShardId shard) {
    TERRAY_ASSERT(shard.mip == 0);
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    std::unique_ptr<ShardFile> file(new ShardFile);
    file->path_ = path;
    file->shard_ = shard;
    file->format_ = info.format;
    file->source_ = source;
    static const char* const kDrivers[] = {"GTiff", nullptr};
    file->handle_->dataset.reset(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_INTERNAL, kDrivers));
    GDALDataset* dataset = file->handle_->dataset.get();
    int blockX = 0, blockY = 0;
    if (dataset && dataset->GetRasterCount() == 1) {
        dataset->GetRasterBand(1)->GetBlockSize(&blockX, &blockY);
    }
    if (blockX != kBlockPosts || blockY != kBlockPosts ||
        dataset->GetRasterXSize() != info.scheme.columns ||
        dataset->GetRasterYSize() != info.scheme.rows ||
        GDALGetDataTypeName(dataset->GetRasterBand(1)->GetRasterDataType()) != source.type) {
        return makeError(ErrorCode::Input,
                         "'{}' is not the source of {} x {} {} samples in blocks of 512 x 512 that "
                         "the store uses in place",
                         path, info.scheme.columns, info.scheme.rows, source.type);
    }
    return file;
}

/// Before anything is allocated or read by what a header claims.
Result<void> ShardFile::check(const TerrainInfo& info, ShardId shard) const {
    GDALDataset& dataset = *handle_->dataset;
    const BlockGrid grid(info.scheme, shard.mip);
    const int width = grid.widthOf(shard.x0, grid.blocksOf(shard)), height = grid.heightOf(shard.y);
    const GDALDataType type = info.format == PostFormat::Int16 ? GDT_UInt16 : GDT_Float32;
    int blockX = 0, blockY = 0;
    const bool one = dataset.GetRasterCount() == 1;
    if (one) dataset.GetRasterBand(1)->GetBlockSize(&blockX, &blockY);
    if (!one || dataset.GetRasterXSize() != width || dataset.GetRasterYSize() != height ||
        blockX != kBlockPosts || blockY != kBlockPosts ||
        dataset.GetRasterBand(1)->GetRasterDataType() != type) {
        return makeError(ErrorCode::Input,
                         "'{}' is not the height file that the store says: it should have {} x {} "
                         "{} samples in blocks of 512 x 512",
                         path_, width, height, GDALGetDataTypeName(type));
    }
    return {};
}

Result<void> ShardFile::readRaw(int x, void* out) {
    clearGdalMessage();
    const GdalScope scope;
    GDALRasterBand& band = *handle_->dataset->GetRasterBand(1);
    const int column = source_ ? x : x - shard_.x0, row = source_ ? shard_.y : 0;
    bytesRead_ += storedBlockBytes(band, column, row);
    if (band.ReadBlock(column, row, out) != CE_None) {
        return makeError(ErrorCode::Input, "block {} of '{}' cannot be decoded: {}", x - shard_.x0,
                         path_, gdalMessage());
    }
    return {};
}

Result<void> ShardFile::read(int x, float* posts) {
    TERRAY_ASSERT(format_ == PostFormat::Float32);
    TERRAY_TRY(readRaw(x, posts));
    if (source_) source_->toPosts({posts, kBlockSamples});
    return {};
}

Result<void> ShardFile::read(int x, uint16_t* codes) {
    TERRAY_ASSERT(format_ == PostFormat::Int16);
    TERRAY_TRY(readRaw(x, codes));
    if (source_) source_->toCodes({codes, kBlockSamples});
    return {};
}

}  // namespace terray
