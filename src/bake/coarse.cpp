// SPDX-License-Identifier: Apache-2.0
// Coarser mips: fitted from the decoded posts of the next finer one, file by file.
#include "bake/workshop.h"
#include "base/workers.h"
#include "tile/codes.h"
#include "tile/mips.h"

namespace terray {
namespace {

constexpr int kStripRows = 64;  ///< fitted at once: the window stays in a core's cache

/// Posts of one shard before they are encoded.
struct ShardPosts {
    int width = 0, height = 0;
    std::vector<float> posts;
};

/// One thread's tools.
struct Maker {
    ShardReaders readers;
    CoarseFitter fitter;
    ShardPosts shard;
    std::vector<uint16_t> codes;
};

Result<void> fitBlock(Workshop& shop, Maker& maker, ShardId shard, int x) {
    const BlockGrid grid = shop.grid(shard.mip);
    const int64_t column = int64_t{shard.x0 + x} * kBlockPosts;
    const int width = grid.widthOf(shard.x0 + x);
    constexpr int kHalo = 2 * kFitRounds + 1;  // finer posts that the fit looks at beyond its own
    for (int first = 0; first < maker.shard.height; first += kStripRows) {
        const int rows = std::min(kStripRows, maker.shard.height - first);
        const int64_t row = int64_t{shard.y} * kBlockPosts + first;
        const auto fine = BlockRows::load(shop.cache, maker.readers, shop.info(), shard.mip - 1,
                                          2 * column - kHalo, 2 * row - kHalo,
                                          2 * width + 2 * kHalo, 2 * rows + 2 * kHalo);
        if (!fine) return fine.error();
        float* out = maker.shard.posts.data() + int64_t{first} * maker.shard.width +
                     int64_t{x} * kBlockPosts;
        maker.fitter.fit(*fine, column, row, width, rows, out, maker.shard.width);
    }
    return {};
}

Result<void> makeShard(Workshop& shop, Maker& maker, ShardId shard) {
    const BlockGrid grid = shop.grid(shard.mip);
    const int blocks = grid.blocksOf(shard);
    ShardPosts& posts = maker.shard;
    posts.width = grid.widthOf(shard.x0, blocks);
    posts.height = grid.heightOf(shard.y);
    posts.posts.resize(static_cast<size_t>(posts.width) * static_cast<size_t>(posts.height));
    for (int x = 0; x < blocks; ++x) TERRAY_TRY(fitBlock(shop, maker, shard, x));
    const TerrainInfo& info = shop.info();
    if (info.format == PostFormat::Float32) {
        return finishShard(shop, shard, posts.posts.data(), posts.width);
    }
    const auto count = static_cast<int>(posts.posts.size());
    maker.codes.resize(posts.posts.size());
    encodeHeights(posts.posts.data(), count, info.z0, info.zStep, maker.codes.data());
    roundCodes(maker.codes.data(), count, shop.plan.codec.codeStep());
    return finishShard(shop, shard, maker.codes.data(), posts.width);
}

}  // namespace

CoarseMaker::CoarseMaker(Workshop& shop)
    : shop_(shop), rows_(static_cast<size_t>(shop.info().scheme.mipCount()), 0) {}

Result<void> CoarseMaker::advance(int rows) {
    rows_[0] = rows;
    for (int mip = 1; mip < static_cast<int>(rows_.size()); ++mip) TERRAY_TRY(advanceMip(mip));
    return {};
}

Result<void> CoarseMaker::advanceMip(int mip) {
    const BlockGrid grid = shop_.grid(mip), finer = shop_.grid(mip - 1);
    const int finerRows = rows_[static_cast<size_t>(mip - 1)];
    int to = rows_[static_cast<size_t>(mip)];
    const auto canMake = [&](int row) {
        const int64_t last = std::min<int64_t>(int64_t{row + 1} * kBlockPosts, grid.rows) - 1;
        const int64_t needed = std::min(2 * (last + kFitRounds) + 1, finer.rows - 1);
        return needed / kBlockPosts < finerRows;
    };
    while (to < grid.blocksY && canMake(to)) ++to;
    const int from = std::exchange(rows_[static_cast<size_t>(mip)], to);
    return makeShards(mip, from, to);
}

Result<void> CoarseMaker::makeShards(int mip, int from, int to) {
    std::vector<ShardId> missing;
    const BlockGrid grid = shop_.grid(mip);
    for (const ShardId shard : shardsOf(grid, mip, from, to)) {
        if (shop_.folder.isFinished(shardPath(shard))) {
            shop_.progress.advance(grid.blocksOf(shard));
        } else {
            missing.push_back(shard);
        }
    }
    const auto makeMaker = [&] {
        return Result<Maker>(Maker{shop_.readers(), CoarseFitter(), {}, {}});
    };
    const auto make = [&](Maker& maker, int64_t task) {
        return makeShard(shop_, maker, missing[static_cast<size_t>(task)]);
    };
    if (missing.empty()) return {};
    return forEachTask(static_cast<int64_t>(missing.size()), makeMaker, make);
}

}  // namespace terray
