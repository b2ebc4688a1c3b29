// SPDX-License-Identifier: Apache-2.0
// From posts to a finished file and cached blocks.
#include "bake/workshop.h"

namespace terray {
namespace {

std::vector<float>& postsOf(Block& block, const float*) { return block.posts; }
std::vector<uint16_t>& postsOf(Block& block, const uint16_t*) { return block.codes; }

/// Posts that are stored without loss need not be decoded again.
template <class Post>
BlockPtr copyBlock(const Post* posts, int64_t stride, int width, int height) {
    auto block = std::make_shared<Block>();
    std::vector<Post>& out = postsOf(*block, posts);
    out.resize(kBlockSamples);
    for (int row = 0; row < height; ++row) {
        std::copy_n(posts + row * stride, width, out.data() + row * kBlockPosts);
    }
    return block;
}

template <class Post>
Result<void> finishTyped(Workshop& shop, ShardId shard, const Post* posts, int64_t stride,
                         bool isLossless) {
    const BlockGrid grid = shop.grid(shard.mip);
    const auto encoded = encodeShard(shop.info(), shop.plan.codec, shard, posts, stride);
    if (!encoded) return encoded.error();
    const int blocks = grid.blocksOf(shard);
    std::unique_ptr<ShardFile> file;
    if (!isLossless) {
        auto opened = ShardFile::open(*encoded, shop.info(), shard);
        if (!opened) return opened.error();
        file = std::move(*opened);
    }
    for (int x = 0; x < blocks; ++x) {
        const BlockId id{shard.mip, shard.x0 + x, shard.y};
        if (isLossless) {
            shop.cache.put(id, copyBlock(posts + int64_t{x} * kBlockPosts, stride,
                                         grid.widthOf(id.x), grid.heightOf(id.y)));
            continue;
        }
        auto block = std::make_shared<Block>();
        std::vector<Post>& out = postsOf(*block, posts);
        out.resize(kBlockSamples);
        TERRAY_TRY(file->read(id.x, out.data()));
        shop.cache.put(id, std::move(block));
    }
    file.reset();
    TERRAY_TRY(shop.folder.finish(shardPath(shard), encoded->bytes, encoded->blocks));
    shop.progress.advance(blocks);
    return {};
}

}  // namespace

std::vector<ShardId> shardsOf(const BlockGrid& grid, int mip, int from, int to) {
    std::vector<ShardId> shards;
    for (int y = from; y < to; ++y) {
        for (int x = 0; x < grid.blocksX; x += kShardBlocks) shards.push_back({mip, x, y});
    }
    return shards;
}

Result<void> finishShard(Workshop& shop, ShardId shard, const float* posts, int64_t stride) {
    return finishTyped(shop, shard, posts, stride, shop.plan.codec.maxError == 0);
}
Result<void> finishShard(Workshop& shop, ShardId shard, const uint16_t* codes, int64_t stride) {
    return finishTyped(shop, shard, codes, stride, true);
}

}  // namespace terray
