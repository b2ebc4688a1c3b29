// SPDX-License-Identifier: Apache-2.0
// The cache of decoded blocks, and windows over them.
#include "bake/block_cache.h"

#include <algorithm>
#include <cstring>

#include "base/assert.h"
#include "tile/codes.h"

namespace terray {
namespace {

constexpr size_t kOpenFiles = 6, kFewestBlocks = 24;

}  // namespace

Result<BlockPtr> ShardReaders::read(BlockId id) {
    const ShardId shard{id.mip, id.x / kShardBlocks * kShardBlocks, id.y};
    const auto found = std::find_if(files_.begin(), files_.end(),
                                    [&](const auto& file) { return file.first == shard; });
    if (found != files_.end()) {
        files_.splice(files_.begin(), files_, found);
    } else {
        auto file = openShard(folder_, manifest_, shard);
        if (!file) return file.error();
        files_.emplace_front(shard, std::move(*file));
        if (files_.size() > kOpenFiles) files_.pop_back();
    }
    auto block = std::make_shared<Block>();
    if (manifest_.info.format == PostFormat::Int16) {
        block->codes.resize(kBlockSamples);
        TERRAY_TRY(files_.front().second->read(id.x, block->codes.data()));
    } else {
        block->posts.resize(kBlockSamples);
        TERRAY_TRY(files_.front().second->read(id.x, block->posts.data()));
    }
    return BlockPtr(std::move(block));
}

BlockCache::BlockCache(const TerrainInfo& info, uint64_t bytes)
    : most_(std::max<size_t>(bytes / (kBlockSamples * postBytes(info.format)), kFewestBlocks)) {}

void BlockCache::put(BlockId id, BlockPtr block) {
    const std::lock_guard lock(mutex_);
    const auto found = blocks_.find(id);
    if (found != blocks_.end()) {
        used_.erase(found->second.place);
        blocks_.erase(found);
    }
    used_.push_front(id);
    blocks_[id] = {std::move(block), used_.begin()};
    while (blocks_.size() > most_) {
        blocks_.erase(used_.back());
        used_.pop_back();
    }
}

BlockPtr BlockCache::find(BlockId id) {
    const std::lock_guard lock(mutex_);
    const auto found = blocks_.find(id);
    if (found == blocks_.end()) return nullptr;
    used_.splice(used_.begin(), used_, found->second.place);
    return found->second.block;
}

Result<BlockPtr> BlockCache::load(BlockId id, ShardReaders& readers) {
    if (BlockPtr block = find(id)) return block;
    Result<BlockPtr> block = readers.read(id);
    if (block) put(id, *block);
    return block;
}

Result<BlockRows> BlockRows::load(BlockCache& cache, ShardReaders& readers, const TerrainInfo& info,
                                  int mip, int64_t column, int64_t row, int64_t width,
                                  int64_t height) {
    BlockRows window(info);
    window.columns_ = info.scheme.columnsAt(mip);
    window.rows_ = info.scheme.rowsAt(mip);
    const auto blockOf = [](int64_t post, int64_t count) {
        return static_cast<int>(std::clamp<int64_t>(post, 0, count - 1) / kBlockPosts);
    };
    window.firstX_ = blockOf(column, window.columns_);
    window.firstY_ = blockOf(row, window.rows_);
    window.blocksX_ = blockOf(column + width - 1, window.columns_) - window.firstX_ + 1;
    const int lastY = blockOf(row + height - 1, window.rows_);
    for (int y = window.firstY_; y <= lastY; ++y) {
        for (int x = 0; x < window.blocksX_; ++x) {
            auto block = cache.load({mip, window.firstX_ + x, y}, readers);
            if (!block) return block.error();
            window.blocks_.push_back(std::move(*block));
        }
    }
    return window;
}

template <class Take>
void BlockRows::each(int64_t row, int64_t column, int64_t count, const Take& take) const {
    const int64_t y = row / kBlockPosts - firstY_;
    const int64_t inBlock = row % kBlockPosts * kBlockPosts;
    int64_t done = 0;
    while (done < count) {
        const int64_t x = (column + done) / kBlockPosts - firstX_;
        const int64_t at = (column + done) % kBlockPosts;
        const int64_t part = std::min(count - done, kBlockPosts - at);
        const int64_t index = y * blocksX_ + x;
        TERRAY_ASSERT(x >= 0 && x < blocksX_ && y >= 0 &&
                      index < static_cast<int64_t>(blocks_.size()));
        take(*blocks_[static_cast<size_t>(index)], inBlock + at, part, done);
        done += part;
    }
}

void BlockRows::read(int64_t row, int64_t column, int64_t count, float* out) const {
    each(row, column, count, [&](const Block& block, int64_t at, int64_t part, int64_t done) {
        if (block.codes.empty()) {
            std::copy_n(block.posts.data() + at, part, out + done);
        } else {
            decodeCodes(block.codes.data() + at, static_cast<int>(part), z0_, zStep_, out + done);
        }
    });
}

void BlockRows::readCodes(int64_t row, int64_t column, int64_t count, uint16_t* out) const {
    each(row, column, count, [&](const Block& block, int64_t at, int64_t part, int64_t done) {
        std::copy_n(block.codes.data() + at, part, out + done);
    });
}

}  // namespace terray
