// SPDX-License-Identifier: Apache-2.0
// What all steps of a bake share: plan, folder, cache, progress; and what one thread needs.
#pragma once

#include "bake/block_cache.h"
#include "bake/plan.h"
#include "bake/work_folder.h"
#include "base/progress.h"

namespace terray {

/// How sources are read: as tall as this, they are in blocks and are cut into columns too.
constexpr int64_t kTallRows = 256;
constexpr int64_t kReadColumns = int64_t{kShardBlocks} * kBlockPosts;

/// What a thread reads at once.
struct Window {
    int64_t column = 0, row = 0, width = 0, height = 0;
};

/// synchronised, as its parts are.
struct Workshop {
    const BakePlan& plan;
    WorkFolder& folder;
    BlockCache& cache;
    Progress& progress;  ///< counts blocks, each twice: made and measured

    const TerrainInfo& info() const { return plan.info(); }
    BlockGrid grid(int mip) const { return {info().scheme, mip}; }
    ShardReaders readers() const { return {folder.path(), plan.manifest}; }
};

/// All shards of rows [from, to) of a mip's blocks, row by row.
std::vector<ShardId> shardsOf(const BlockGrid& grid, int mip, int from, int to);

/// Encodes a shard's posts, finishes its file and puts its decoded blocks into the cache. Codes are
/// rounded already.
Result<void> finishShard(Workshop& shop, ShardId shard, const float* posts, int64_t stride);
Result<void> finishShard(Workshop& shop, ShardId shard, const uint16_t* codes, int64_t stride);

/// Reads the source once, front to back, into the files of mip 0; coarser ones are made as their
/// rows become known. Finished files are left as they are.
Result<void> makeHeights(Workshop& shop);

/// Makes the photo's files and VRTs, if there is one.
Result<void> makePhoto(Workshop& shop);
/// Its files, in the order of the manifest.
std::vector<std::string> photoFiles(const PhotoLayer& layer);
double photoBlockCount(const PhotoLayer& layer);

/// Makes the files of the coarser mips as far as finer rows are there.
class CoarseMaker {
public:
    explicit CoarseMaker(Workshop& shop);
    /// Rows [0, rows) of mip 0's blocks are finished.
    Result<void> advance(int rows);

private:
    Result<void> advanceMip(int mip);
    Result<void> makeShards(int mip, int from, int to);
    Workshop& shop_;
    std::vector<int> rows_;  ///< finished rows of blocks, per mip
};

}  // namespace terray
