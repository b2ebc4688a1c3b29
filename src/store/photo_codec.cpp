// SPDX-License-Identifier: Apache-2.0
// Encoding of photo files, block by block and past GDAL's block cache, so that the bytes depend on
// the pixels alone.
#include "store/photo_codec.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>

#include "dataset/gdal_handle.h"
#include "store/gdal_scope.h"

namespace terray {
namespace {

constexpr int kUnit = 16;      ///< pixels a side of what JPEG transforms together, colours halved
constexpr int kCovered = 128;  ///< alpha from which on a pixel of a JPEG counts as covered
constexpr size_t kBlockPixels = size_t{kBlockPosts} * kBlockPosts;

using Rgba = std::array<uint8_t, 4>;

/// A block, pixel by pixel.
struct PixelBlock {
    std::vector<Rgba> pixels = std::vector<Rgba>(kBlockPixels);
    Rgba& at(int x, int y) {
        return pixels[static_cast<size_t>(y) * kBlockPosts + static_cast<size_t>(x)];
    }
};

/// A block with its padding: the last row and column repeated.
void takeBlock(const uint8_t* rgba, int64_t stride, int width, int height, PixelBlock& block) {
    for (int y = 0; y < kBlockPosts; ++y) {
        const uint8_t* from = rgba + std::min(y, height - 1) * stride;
        for (int x = 0; x < kBlockPosts; ++x) {
            std::copy_n(from + 4 * std::min(x, width - 1), 4, block.at(x, y).data());
        }
    }
}

/// Sums of the covered pixels of a square.
struct Mean {
    std::array<uint64_t, 3> sum{};
    uint64_t count = 0;
    void add(const Rgba& pixel) {
        if (pixel[3] < kCovered) return;
        for (size_t c = 0; c < 3; ++c) sum[c] += pixel[c];
        ++count;
    }
    Rgba value() const {
        Rgba mean{};
        for (size_t c = 0; c < 3 && count > 0; ++c) {
            mean[c] = static_cast<uint8_t>((sum[c] + count / 2) / count);
        }
        return mean;
    }
};

/// Gives what is not covered the colour of what is covered beside it: a step to black would ring
/// into the picture.
void fillUncovered(PixelBlock& block) {
    Mean all;
    for (const Rgba& pixel : block.pixels) all.add(pixel);
    if (all.count == kBlockPixels) return;
    for (int top = 0; top < kBlockPosts; top += kUnit) {
        for (int left = 0; left < kBlockPosts; left += kUnit) {
            Mean unit;
            for (int k = 0; k < kUnit * kUnit; ++k) {
                unit.add(block.at(left + k % kUnit, top + k / kUnit));
            }
            if (unit.count == kUnit * kUnit) continue;
            const Rgba mean = unit.count > 0 ? unit.value() : all.value();
            for (int k = 0; k < kUnit * kUnit; ++k) {
                Rgba& pixel = block.at(left + k % kUnit, top + k / kUnit);
                if (pixel[3] < kCovered) std::copy_n(mean.data(), 3, pixel.data());
            }
        }
    }
}

bool isCovered(const uint8_t* rgba, int64_t stride, int width, int height) {
    for (int row = 0; row < height; ++row) {
        for (int k = 0; k < width; ++k) {
            if (rgba[row * stride + 4 * k + 3] < kCovered) return false;
        }
    }
    return true;
}

CPLStringList creationOptions(const PhotoLayer& layer) {
    CPLStringList options;
    options.SetNameValue("TILED", "YES");
    options.SetNameValue("BLOCKXSIZE", std::to_string(kBlockPosts).c_str());
    options.SetNameValue("BLOCKYSIZE", std::to_string(kBlockPosts).c_str());
    options.SetNameValue("BIGTIFF", "NO");
    options.SetNameValue("INTERLEAVE", "PIXEL");
    if (layer.isLossless()) {
        options.SetNameValue("COMPRESS", "ZSTD");
        options.SetNameValue("PREDICTOR", "2");
        options.SetNameValue("PHOTOMETRIC", "RGB");
        options.SetNameValue("ALPHA", "NON-PREMULTIPLIED");
    } else {
        options.SetNameValue("COMPRESS", "JPEG");
        options.SetNameValue("PHOTOMETRIC", "YCBCR");
        options.SetNameValue("JPEG_QUALITY", std::to_string(layer.quality).c_str());
    }
    return options;
}

bool describe(GDALDataset& dataset, const TerrainInfo& info, const PhotoLayer& layer,
              ShardId shard) {
    GeoTransform transform =
        layer.geoTransform(info.metresPerCrsUnit, shard.mip, int64_t{shard.x0} * kBlockPosts,
                           int64_t{shard.y} * kBlockPosts);
    if (dataset.SetGeoTransform(transform.values) != CE_None) return false;
    if (info.crsWkt.empty()) return true;
    OGRSpatialReference crs;
    if (crs.importFromWkt(info.crsWkt.c_str()) != OGRERR_NONE) return false;
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return dataset.SetSpatialRef(&crs) == CE_None;
}

/// One channel of a block into a band.
bool writeChannel(GDALRasterBand& band, int x, PixelBlock& block, size_t channel,
                  std::vector<uint8_t>& scratch) {
    scratch.resize(kBlockPixels);
    for (size_t k = 0; k < kBlockPixels; ++k) scratch[k] = block.pixels[k][channel];
    return band.WriteBlock(x, 0, scratch.data()) == CE_None;
}

bool writeMask(GDALRasterBand& band, int x, PixelBlock& block, std::vector<uint8_t>& scratch) {
    scratch.resize(kBlockPixels);
    for (size_t k = 0; k < kBlockPixels; ++k) {
        scratch[k] = block.pixels[k][3] < kCovered ? 0 : 255;
    }
    return band.WriteBlock(x, 0, scratch.data()) == CE_None;
}

/// Places of the blocks in the finished file: all colours, then all masks if there are any.
void addRanges(GDALRasterBand& band, int blocks, std::vector<BlockRange>& ranges) {
    for (int x = 0; x < blocks; ++x) {
        const auto number = [&](const char* key) -> uint64_t {
            const char* text = band.GetMetadataItem(fmt::format("{}_{}_0", key, x).c_str(), "TIFF");
            return text ? std::strtoull(text, nullptr, 10) : 0;
        };
        ranges.push_back({number("BLOCK_OFFSET"), number("BLOCK_SIZE")});
    }
}

bool writeBlocks(GDALDataset& dataset, const BlockGrid& grid, ShardId shard, const uint8_t* rgba,
                 int64_t stride, bool hasMask) {
    PixelBlock block;
    std::vector<uint8_t> scratch;
    const int height = grid.heightOf(shard.y), blocks = grid.blocksOf(shard);
    const auto take = [&](int x) {
        takeBlock(rgba + int64_t{x} * kBlockPosts * 4, stride, grid.widthOf(shard.x0 + x), height,
                  block);
    };
    const bool isJpeg = dataset.GetRasterCount() == 3;
    for (int x = 0; x < blocks; ++x) {
        take(x);
        if (isJpeg && hasMask) fillUncovered(block);
        for (int band = 1; band <= dataset.GetRasterCount(); ++band) {
            if (!writeChannel(*dataset.GetRasterBand(band), x, block, static_cast<size_t>(band - 1),
                              scratch)) {
                return false;
            }
        }
    }
    for (int x = 0; hasMask && x < blocks; ++x) {
        take(x);
        if (!writeMask(*dataset.GetRasterBand(1)->GetMaskBand(), x, block, scratch)) return false;
    }
    return true;
}

/// Removes a file in memory at the end.
struct MemoryFile {
    std::string name = memoryFileName();
    MemoryFile() = default;
    ~MemoryFile() { VSIUnlink(name.c_str()); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
};

}  // namespace

Result<EncodedFile> encodePhotoShard(const TerrainInfo& info, const PhotoLayer& layer,
                                     ShardId shard, const uint8_t* rgba, int64_t stride) {
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    const CPLConfigOptionSetter inside("GDAL_TIFF_INTERNAL_MASK", "YES", false);
    const BlockGrid grid = layer.grid(shard.mip);
    const int blocks = grid.blocksOf(shard);
    const int width = grid.widthOf(shard.x0, blocks), height = grid.heightOf(shard.y);
    const bool hasMask = !layer.isLossless() && !isCovered(rgba, stride, width, height);
    const auto fail = [&] {
        return makeError(ErrorCode::Failed, "GDAL cannot encode '{}': {}", photoShardPath(shard),
                         gdalMessage());
    };
    const MemoryFile memory;
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    DatasetHandle dataset(driver->Create(memory.name.c_str(), width, height,
                                         layer.isLossless() ? 4 : 3, GDT_Byte,
                                         creationOptions(layer).List()));
    if (!dataset || !describe(*dataset, info, layer, shard)) return fail();
    if (hasMask && dataset->CreateMaskBand(GMF_PER_DATASET) != CE_None) return fail();
    if (!writeBlocks(*dataset, grid, shard, rgba, stride, hasMask)) return fail();
    dataset.reset();
    dataset.reset(GDALDataset::Open(memory.name.c_str(), GDAL_OF_RASTER | GDAL_OF_INTERNAL));
    if (!dataset) return fail();
    EncodedFile file;
    addRanges(*dataset->GetRasterBand(1), blocks, file.blocks);
    if (hasMask) addRanges(*dataset->GetRasterBand(1)->GetMaskBand(), blocks, file.blocks);
    dataset.reset();
    vsi_l_offset size = 0;
    const auto* bytes =
        reinterpret_cast<const std::byte*>(VSIGetMemFileBuffer(memory.name.c_str(), &size, FALSE));
    if (bytes == nullptr) return fail();
    file.bytes.assign(bytes, bytes + size);
    return file;
}

struct PhotoShardFile::Handle {
    DatasetHandle dataset;
};

PhotoShardFile::PhotoShardFile() : handle_(std::make_unique<Handle>()) {}
PhotoShardFile::~PhotoShardFile() = default;

Result<std::unique_ptr<PhotoShardFile>> PhotoShardFile::open(const std::string& path,
                                                             const PhotoLayer& layer,
                                                             ShardId shard) {
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    std::unique_ptr<PhotoShardFile> file(new PhotoShardFile);
    const BlockGrid grid = layer.grid(shard.mip);
    file->path_ = path;
    file->shard_ = shard;
    file->width_ = grid.widthOf(shard.x0, grid.blocksOf(shard));
    file->height_ = grid.heightOf(shard.y);
    file->isLossless_ = layer.isLossless();
    static const char* const kDrivers[] = {"GTiff", nullptr};
    file->handle_->dataset.reset(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_INTERNAL, kDrivers));
    if (!file->handle_->dataset) {
        return makeError(ErrorCode::Input, "'{}' cannot be opened: {}", path, gdalMessage());
    }
    TERRAY_TRY(file->check());
    return file;
}

/// Before anything is read by what a header claims.
Result<void> PhotoShardFile::check() const {
    GDALDataset& dataset = *handle_->dataset;
    const int bands = isLossless_ ? 4 : 3;
    bool fits = dataset.GetRasterCount() == bands && dataset.GetRasterXSize() == width_ &&
                dataset.GetRasterYSize() == height_;
    for (int band = 1; fits && band <= bands; ++band) {
        int blockX = 0, blockY = 0;
        dataset.GetRasterBand(band)->GetBlockSize(&blockX, &blockY);
        fits = blockX == kBlockPosts && blockY == kBlockPosts &&
               dataset.GetRasterBand(band)->GetRasterDataType() == GDT_Byte;
    }
    if (fits) return {};
    return makeError(ErrorCode::Input,
                     "'{}' is not the photo file that the store says: it should have {} bands of "
                     "{} x {} bytes in blocks of 512 x 512",
                     path_, bands, width_, height_);
}

Result<void> PhotoShardFile::read(int x, uint8_t* rgba) {
    clearGdalMessage();
    const GdalScope scope;
    GDALDataset& dataset = *handle_->dataset;
    const int left = (x - shard_.x0) * kBlockPosts;
    const int width = std::min(width_ - left, kBlockPosts);
    constexpr GSpacing kLine = GSpacing{kBlockPosts} * 4;
    std::fill_n(rgba, kPhotoBlockBytes, uint8_t{0});
    const int bands = isLossless_ ? 4 : 3;
    bytesRead_ += storedBlockBytes(*dataset.GetRasterBand(1), x - shard_.x0, 0);
    bool done = dataset.RasterIO(GF_Read, left, 0, width, height_, rgba, width, height_, GDT_Byte,
                                 bands, nullptr, 4, kLine, 1, nullptr) == CE_None;
    if (!isLossless_ && done) {
        if (dataset.GetRasterBand(1)->GetMaskFlags() == GMF_PER_DATASET)
            bytesRead_ +=
                storedBlockBytes(*dataset.GetRasterBand(1)->GetMaskBand(), x - shard_.x0, 0);
        done = dataset.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Read, left, 0, width, height_,
                                                                 rgba + 3, width, height_, GDT_Byte,
                                                                 4, kLine, nullptr) == CE_None;
    }
    if (!done) {
        return makeError(ErrorCode::Input, "block {} of '{}' cannot be decoded: {}", x - shard_.x0,
                         path_, gdalMessage());
    }
    for (size_t k = 0; k < kPhotoBlockBytes; k += 4) {
        if (rgba[k + 3] == 0) std::fill_n(rgba + k, 4, uint8_t{0});
    }
    return {};
}

}  // namespace terray
