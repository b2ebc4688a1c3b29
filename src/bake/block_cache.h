// SPDX-License-Identifier: Apache-2.0
// Decoded blocks of the store that is being made: the last used ones in memory, the others read
// again from its files.
#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "store/format.h"
#include "store/manifest.h"
#include "store/shard_codec.h"
#include "tile/mips.h"

namespace terray {

struct BlockId {
    int mip = 0, x = 0, y = 0;
    friend auto operator<=>(const BlockId&, const BlockId&) = default;
};

/// 512 x 512 posts: codes or floats, by the store's format.
struct Block {
    std::vector<uint16_t> codes;
    std::vector<float> posts;
};
using BlockPtr = std::shared_ptr<const Block>;

/// Open height files of one thread. confined.
class ShardReaders {
public:
    ShardReaders(std::string folder, const StoreManifest& manifest)
        : folder_(std::move(folder)), manifest_(manifest) {}
    Result<BlockPtr> read(BlockId id);

private:
    std::string folder_;
    const StoreManifest& manifest_;
    std::list<std::pair<ShardId, std::unique_ptr<ShardFile>>> files_;  ///< last used first
};

/// synchronised.
class BlockCache {
public:
    BlockCache(const TerrainInfo& info, uint64_t bytes);
    void put(BlockId id, BlockPtr block);
    /// From memory, or by `readers`.
    Result<BlockPtr> load(BlockId id, ShardReaders& readers);

private:
    BlockPtr find(BlockId id);
    struct Entry {
        BlockPtr block;
        std::list<BlockId>::iterator place;
    };
    size_t most_;
    std::mutex mutex_;
    std::map<BlockId, Entry> blocks_;
    std::list<BlockId> used_;  ///< last used first
};

/// A window of a mip's decoded posts, held in memory. confined.
class BlockRows final : public PostRows {
public:
    /// Posts [column, column + width) x [row, row + height), cut to the mip.
    static Result<BlockRows> load(BlockCache& cache, ShardReaders& readers, const TerrainInfo& info,
                                  int mip, int64_t column, int64_t row, int64_t width,
                                  int64_t height);
    int64_t columns() const override { return columns_; }
    int64_t rows() const override { return rows_; }
    void read(int64_t row, int64_t column, int64_t count, float* out) const override;
    /// The same as stored.
    void readCodes(int64_t row, int64_t column, int64_t count, uint16_t* out) const;

private:
    explicit BlockRows(const TerrainInfo& info) : z0_(info.z0), zStep_(info.zStep) {}
    template <class Take>
    void each(int64_t row, int64_t column, int64_t count, const Take& take) const;

    int64_t columns_ = 0, rows_ = 0;
    int firstX_ = 0, firstY_ = 0, blocksX_ = 0;
    float z0_, zStep_;
    std::vector<BlockPtr> blocks_;
};

}  // namespace terray
