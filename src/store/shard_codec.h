// SPDX-License-Identifier: Apache-2.0
// Height files: a run of blocks of one mip as a tiled GeoTIFF, encoded in memory, decoded by block.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "store/bytes.h"
#include "store/format.h"
#include "store/hashes.h"
#include "store/in_place.h"

class GDALDataset;

namespace terray {

/// How heights may change on their way into the store.
struct HeightCodec {
    PostFormat format = PostFormat::Float32;
    float z0 = 0, zStep = 0;  ///< of codes
    double maxError = 0;      ///< metres; 0: lossless

    /// Codes become multiples of this (a power of two), so that they stay within maxError.
    int codeStep() const;
};

/// Multiples of `step` (a power of two), each the nearest one that is a code; holes stay.
void roundCodes(uint16_t* codes, int64_t count, int step);

struct EncodedFile {
    Bytes bytes;
    std::vector<BlockRange> blocks;
};

/// Posts of a shard, `stride` apart from row to row: BlockGrid says how many. Deterministic. Codes
/// are rounded to codeStep() by the caller. Floats are encoded so that what is read differs by at
/// most maxError. Error Failed.
Result<EncodedFile> encodeShard(const TerrainInfo& info, const HeightCodec& codec, ShardId shard,
                                const float* posts, int64_t stride);
Result<EncodedFile> encodeShard(const TerrainInfo& info, const HeightCodec& codec, ShardId shard,
                                const uint16_t* codes, int64_t stride);

/// An open height file. confined.
class ShardFile {
public:
    /// Error Input if it is not what the store says. `bytes` in memory, or the file at `path`.
    static Result<std::unique_ptr<ShardFile>> open(const std::string& path, const TerrainInfo& info,
                                                   ShardId shard);
    static Result<std::unique_ptr<ShardFile>> open(const EncodedFile& file, const TerrainInfo& info,
                                                   ShardId shard);
    /// Blocks of a row of the source that is mip 0, as if they were a height file.
    static Result<std::unique_ptr<ShardFile>> openInPlace(const std::string& path,
                                                          const InPlaceSource& source,
                                                          const TerrainInfo& info, ShardId shard);
    ~ShardFile();
    ShardFile(const ShardFile&) = delete;
    ShardFile& operator=(const ShardFile&) = delete;

    /// Block x of the mip (not of the file): 512 x 512 posts; beyond the mip's edge anything.
    Result<void> read(int x, float* posts);
    Result<void> read(int x, uint16_t* codes);
    /// Bytes of all blocks that were read, as they lie in the file.
    uint64_t bytesRead() const { return bytesRead_; }

private:
    ShardFile();
    Result<void> check(const TerrainInfo& info, ShardId shard) const;
    Result<void> readRaw(int x, void* out);

    std::string path_;
    std::string memoryFile_;  ///< to be unlinked; empty: none
    ShardId shard_;
    std::optional<InPlaceSource> source_;  ///< set: the file is all of mip 0, its samples raw
    PostFormat format_ = PostFormat::Float32;
    uint64_t bytesRead_ = 0;
    struct Handle;
    std::unique_ptr<Handle> handle_;
};

}  // namespace terray
