// SPDX-License-Identifier: Apache-2.0
// Encoding of height files. Blocks are handed over whole, with their padding, and past GDAL's block
// cache, so that the bytes depend on the posts alone.
#include "store/shard_codec.h"

#include <cpl_string.h>
#include <cpl_vsi.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/assert.h"
#include "dataset/gdal_handle.h"
#include "store/gdal_scope.h"

namespace terray {
namespace {

constexpr double kBoundShare = 0.999;  ///< LERC was measured to miss 0.05 by 2e-7

Error encodeError(ShardId shard) {
    return makeError(ErrorCode::Failed, "GDAL cannot encode '{}': {}", shardPath(shard),
                     gdalMessage());
}

/// The bound to give to LERC: the float that comes out is rounded once more. Not above zero: no
/// bound is safe, encode without loss.
double lercBound(double maxError, float magnitude) {
    const float next = std::nextafter(magnitude, std::numeric_limits<float>::infinity());
    const double ulp = static_cast<double>(next) - static_cast<double>(magnitude);
    return std::min(kBoundShare * maxError, maxError - ulp);
}

template <class Post>
float largestMagnitude(const Post* posts, int64_t stride, int width, int height) {
    float largest = 0;
    for (int row = 0; row < height; ++row) {
        for (int k = 0; k < width; ++k) {
            const float z = std::fabs(static_cast<float>(posts[row * stride + k]));
            largest = z > largest ? z : largest;  // NaN never is
        }
    }
    return largest;
}

CPLStringList creationOptions(PostFormat format, double bound) {
    CPLStringList options;
    options.SetNameValue("TILED", "YES");
    options.SetNameValue("BLOCKXSIZE", std::to_string(kBlockPosts).c_str());
    options.SetNameValue("BLOCKYSIZE", std::to_string(kBlockPosts).c_str());
    options.SetNameValue("BIGTIFF", "NO");
    if (bound > 0) {
        options.SetNameValue("COMPRESS", "LERC_ZSTD");
        options.SetNameValue("MAX_Z_ERROR", fmt::format("{}", bound).c_str());
    } else {
        options.SetNameValue("COMPRESS", "ZSTD");
        options.SetNameValue("PREDICTOR", format == PostFormat::Int16 ? "2" : "3");
    }
    return options;
}

bool describe(GDALDataset& dataset, const TerrainInfo& info, const HeightCodec& codec,
              ShardId shard) {
    GeoTransform transform = geoTransformOf(info, shard.mip, int64_t{shard.x0} * kBlockPosts,
                                            int64_t{shard.y} * kBlockPosts);
    if (dataset.SetGeoTransform(transform.values) != CE_None) return false;
    if (!info.crsWkt.empty()) {
        OGRSpatialReference crs;
        if (crs.importFromWkt(info.crsWkt.c_str()) != OGRERR_NONE) return false;
        crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        if (dataset.SetSpatialRef(&crs) != CE_None) return false;
    }
    GDALRasterBand& band = *dataset.GetRasterBand(1);
    band.SetUnitType("m");
    if (codec.format == PostFormat::Float32) {
        return band.SetNoDataValue(std::numeric_limits<double>::quiet_NaN()) == CE_None;
    }
    return band.SetNoDataValue(kHolePost) == CE_None &&
           band.SetScale(static_cast<double>(codec.zStep)) == CE_None &&
           band.SetOffset(static_cast<double>(codec.z0)) == CE_None;
}

/// A block with its padding: the last column and row repeated.
template <class Post>
void takeBlock(const Post* posts, int64_t stride, int width, int height, Post* block) {
    for (int row = 0; row < kBlockPosts; ++row) {
        Post* out = block + row * kBlockPosts;
        const Post* from = posts + std::min(row, height - 1) * stride;
        std::copy(from, from + width, out);
        std::fill(out + width, out + kBlockPosts, from[width - 1]);
    }
}

std::vector<BlockRange> blockRanges(GDALDataset& dataset, int blocks) {
    std::vector<BlockRange> ranges;
    GDALRasterBand& band = *dataset.GetRasterBand(1);
    for (int x = 0; x < blocks; ++x) {
        const auto number = [&](const char* key) -> uint64_t {
            const char* text = band.GetMetadataItem(fmt::format("{}_{}_0", key, x).c_str(), "TIFF");
            return text ? std::strtoull(text, nullptr, 10) : 0;
        };
        ranges.push_back({number("BLOCK_OFFSET"), number("BLOCK_SIZE")});
    }
    return ranges;
}

template <class Post>
Result<EncodedFile> encode(const TerrainInfo& info, const HeightCodec& codec, ShardId shard,
                           const Post* posts, int64_t stride) {
    ensureGdal();
    clearGdalMessage();
    const GdalScope scope;
    const BlockGrid grid(info.scheme, shard.mip);
    const int blocks = grid.blocksOf(shard);
    const int width = grid.widthOf(shard.x0, blocks), height = grid.heightOf(shard.y);
    double bound = 0;
    if (codec.format == PostFormat::Float32 && codec.maxError > 0) {
        bound = lercBound(codec.maxError, largestMagnitude(posts, stride, width, height));
    }
    const std::string name = memoryFileName();
    struct Unlink {
        const std::string& name;
        ~Unlink() { VSIUnlink(name.c_str()); }
    } unlink{name};
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    DatasetHandle dataset(
        driver->Create(name.c_str(), width, height, 1,
                       codec.format == PostFormat::Int16 ? GDT_UInt16 : GDT_Float32,
                       creationOptions(codec.format, bound).List()));
    if (!dataset || !describe(*dataset, info, codec, shard)) return encodeError(shard);
    std::vector<Post> block(kBlockSamples);
    for (int x = 0; x < blocks; ++x) {
        takeBlock(posts + int64_t{x} * kBlockPosts, stride, grid.widthOf(shard.x0 + x), height,
                  block.data());
        if (dataset->GetRasterBand(1)->WriteBlock(x, 0, block.data()) != CE_None) {
            return encodeError(shard);
        }
    }
    dataset.reset();
    dataset.reset(GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_INTERNAL));
    if (!dataset) return encodeError(shard);
    EncodedFile file;
    file.blocks = blockRanges(*dataset, blocks);
    dataset.reset();
    vsi_l_offset size = 0;
    const auto* bytes =
        reinterpret_cast<const std::byte*>(VSIGetMemFileBuffer(name.c_str(), &size, FALSE));
    if (bytes == nullptr) return encodeError(shard);
    file.bytes.assign(bytes, bytes + size);
    return file;
}

}  // namespace

int HeightCodec::codeStep() const {
    if (format != PostFormat::Int16 || !(zStep > 0)) return 1;
    int step = 1;
    while (step < 1 << 15 && static_cast<double>(zStep) * step <= maxError) step *= 2;
    return step;  // step / 2 codes of error at most
}

void roundCodes(uint16_t* codes, int64_t count, int step) {
    if (step <= 1) return;
    constexpr int kTop = kHolePost - 1;
    const int half = step / 2;
    for (int64_t k = 0; k < count; ++k) {
        if (codes[k] == kHolePost) continue;
        const int rounded = (codes[k] + half) / step * step;
        codes[k] = static_cast<uint16_t>(rounded > kTop ? kTop : rounded);
    }
}

Result<EncodedFile> encodeShard(const TerrainInfo& info, const HeightCodec& codec, ShardId shard,
                                const float* posts, int64_t stride) {
    TERRAY_ASSERT(codec.format == PostFormat::Float32);
    return encode(info, codec, shard, posts, stride);
}
Result<EncodedFile> encodeShard(const TerrainInfo& info, const HeightCodec& codec, ShardId shard,
                                const uint16_t* codes, int64_t stride) {
    TERRAY_ASSERT(codec.format == PostFormat::Int16);
    return encode(info, codec, shard, codes, stride);
}

}  // namespace terray
