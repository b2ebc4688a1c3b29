// SPDX-License-Identifier: Apache-2.0
// Photo files: a run of blocks of one mip as a tiled GeoTIFF, encoded in memory, decoded by block.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "store/photo_layer.h"
#include "store/shard_codec.h"
#include "tile/photo_blocks.h"

namespace terray {

static_assert(kPhotoBlockSide == kBlockPosts);

/// Straight-alpha pixels of a shard, rows `stride` bytes apart: PhotoLayer::grid says how many.
/// JPEG (YCbCr) with a mask of one bit where something is not covered (alpha below 128); lossless:
/// RGBA, ZSTD. Deterministic. Error Failed.
Result<EncodedFile> encodePhotoShard(const TerrainInfo& info, const PhotoLayer& layer,
                                     ShardId shard, const uint8_t* rgba, int64_t stride);

/// An open photo file. confined.
class PhotoShardFile {
public:
    /// Error Input if it is not what the store says.
    static Result<std::unique_ptr<PhotoShardFile>> open(const std::string& path,
                                                        const PhotoLayer& layer, ShardId shard);
    ~PhotoShardFile();
    PhotoShardFile(const PhotoShardFile&) = delete;
    PhotoShardFile& operator=(const PhotoShardFile&) = delete;

    /// Block x of the mip (not of the file): 512 x 512 pixels of straight-alpha RGBA; 0 where the
    /// photo does not cover and beyond the mip's edge.
    Result<void> read(int x, uint8_t* rgba);
    /// Bytes of all blocks that were read, as they lie in the file.
    uint64_t bytesRead() const { return bytesRead_; }

private:
    PhotoShardFile();
    Result<void> check() const;

    std::string path_;
    ShardId shard_;
    int width_ = 0, height_ = 0;
    bool isLossless_ = false;
    uint64_t bytesRead_ = 0;
    struct Handle;
    std::unique_ptr<Handle> handle_;
};

}  // namespace terray
