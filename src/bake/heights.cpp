// SPDX-License-Identifier: Apache-2.0
// Mip 0: the source in batches of whole rows of blocks, read and encoded on all cores.
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>

#include "bake/workshop.h"
#include "base/workers.h"

namespace terray {
namespace {

constexpr int kHeightShare = 4;  ///< of the memory budget

/// Blocks [x0, x1) x [y0, y1) of mip 0, held in memory at once.
struct Batch {
    int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

Result<void> readInto(HeightReader& reader, const Window& w, std::span<float> out) {
    return reader.read(w.column, w.row, w.width, w.height, out);
}
Result<void> readInto(HeightReader& reader, const Window& w, std::span<uint16_t> out) {
    return reader.readCodes(w.column, w.row, w.width, w.height, out);
}

template <class Post>
class HeightMaker {
public:
    explicit HeightMaker(Workshop& shop)
        : shop_(shop), grid_(shop.grid(0)), source_(*shop.plan.source), coarse_(shop) {}

    Result<void> run() {
        for (const Batch& batch : batches()) {
            if (shop_.plan.manifest.inPlace) {
                shop_.progress.advance(static_cast<double>(batch.x1 - batch.x0) *
                                       (batch.y1 - batch.y0));
            } else {
                TERRAY_TRY(makeBatch(batch));
            }
            if (batch.x1 == grid_.blocksX) TERRAY_TRY(coarse_.advance(batch.y1));
        }
        return {};
    }

private:
    std::vector<Batch> batches() const {
        const auto budget = static_cast<int64_t>(shop_.plan.memoryBytes / kHeightShare);
        const int64_t blockBytes = int64_t{kBlockPosts} * kBlockPosts * int64_t{sizeof(Post)};
        const int64_t blocks = std::max<int64_t>(budget / blockBytes, kShardBlocks);
        int rows = static_cast<int>(std::clamp<int64_t>(blocks / grid_.blocksX, 1, 64));
        const int columns = static_cast<int>(
            std::min<int64_t>(blocks / kShardBlocks * kShardBlocks, grid_.blocksX));
        rows = columns < grid_.blocksX ? 1 : rows;
        std::vector<Batch> all;
        for (int y = 0; y < grid_.blocksY; y += rows) {
            for (int x = 0; x < grid_.blocksX; x += columns) {
                all.push_back({x, std::min(x + columns, grid_.blocksX), y,
                               std::min(y + rows, grid_.blocksY)});
            }
        }
        return all;
    }

    Result<void> makeBatch(const Batch& batch) {
        std::vector<ShardId> missing;
        for (const ShardId shard : shardsOf(grid_, 0, batch.y0, batch.y1)) {
            if (shard.x0 < batch.x0 || shard.x0 >= batch.x1) continue;
            if (shop_.folder.isFinished(shardPath(shard))) {
                shop_.progress.advance(grid_.blocksOf(shard));
            } else {
                missing.push_back(shard);
            }
        }
        if (missing.empty()) return {};
        TERRAY_TRY(readBatch(batch, missing));
        const int step = shop_.plan.codec.codeStep();
        const auto makeNothing = [] { return Result<int>(0); };
        const auto encode = [&](int&, int64_t task) {
            const ShardId shard = missing[static_cast<size_t>(task)];
            Post* from = posts_.data() + rowOf(batch, shard.y) * stride_ +
                         int64_t{shard.x0 - batch.x0} * kBlockPosts;
            if constexpr (std::is_same_v<Post, uint16_t>) {
                const int width = grid_.widthOf(shard.x0, grid_.blocksOf(shard));
                for (int row = 0; step > 1 && row < grid_.heightOf(shard.y); ++row) {
                    roundCodes(from + row * stride_, width, step);
                }
            }
            if constexpr (std::is_same_v<Post, float>) hideInfinite(from, shard);
            return finishShard(shop_, shard, from, stride_);
        };
        return forEachTask(static_cast<int64_t>(missing.size()), makeNothing, encode);
    }

    /// Infinite heights are holes, as they are in a terrain in memory.
    void hideInfinite(Post* posts, ShardId shard) const {
        const int width = grid_.widthOf(shard.x0, grid_.blocksOf(shard));
        for (int row = 0; row < grid_.heightOf(shard.y); ++row) {
            for (int k = 0; k < width; ++k) {
                Post& post = posts[row * stride_ + k];
                if (!(post - post == 0)) post = std::numeric_limits<Post>::quiet_NaN();
            }
        }
    }

    static int64_t rowOf(const Batch& batch, int y) { return int64_t{y - batch.y0} * kBlockPosts; }

    /// Windows that follow the source's own blocks; only rows that a missing shard needs.
    std::vector<Window> windowsOf(const Batch& batch, const std::vector<ShardId>& missing) const {
        const int64_t left = int64_t{batch.x0} * kBlockPosts;
        const int64_t right = left + stride_;
        const int64_t preferred = std::clamp<int64_t>(source_.preferredRows(), 1, kBlockPosts);
        const int64_t tall = std::max<int64_t>(kBlockPosts / 8 / preferred, 1) * preferred;
        const int64_t wide = preferred >= kTallRows ? kReadColumns : stride_;
        std::vector<Window> windows;
        for (int y = batch.y0; y < batch.y1; ++y) {
            const bool isMissing = std::any_of(missing.begin(), missing.end(),
                                               [&](ShardId shard) { return shard.y == y; });
            if (!isMissing) continue;
            const int64_t top = int64_t{y} * kBlockPosts, bottom = top + grid_.heightOf(y);
            for (int64_t row = top; row < bottom; row += tall) {
                for (int64_t column = left; column < right; column += wide) {
                    windows.push_back({column, row, std::min(wide, right - column),
                                       std::min(tall, bottom - row)});
                }
            }
        }
        return windows;
    }

    Result<void> readBatch(const Batch& batch, const std::vector<ShardId>& missing) {
        stride_ = grid_.widthOf(batch.x0, batch.x1 - batch.x0);
        const int64_t rows = rowOf(batch, batch.y1 - 1) + grid_.heightOf(batch.y1 - 1);
        posts_.resize(static_cast<size_t>(stride_ * rows));
        const std::vector<Window> windows = windowsOf(batch, missing);
        struct Reader {
            std::unique_ptr<HeightReader> reader;
            std::vector<Post> scratch;
        };
        const auto makeReader = [&]() -> Result<Reader> {
            auto reader = source_.makeReader();
            if (!reader) return reader.error();
            return Reader{std::move(*reader), {}};
        };
        const auto read = [&](Reader& reader, int64_t task) -> Result<void> {
            const Window& w = windows[static_cast<size_t>(task)];
            Post* to = posts_.data() + (w.row - int64_t{batch.y0} * kBlockPosts) * stride_ +
                       (w.column - int64_t{batch.x0} * kBlockPosts);
            const auto count = static_cast<size_t>(w.width * w.height);
            if (w.width == stride_) return readInto(*reader.reader, w, std::span<Post>(to, count));
            reader.scratch.resize(count);
            TERRAY_TRY(readInto(*reader.reader, w, std::span<Post>(reader.scratch)));
            for (int64_t row = 0; row < w.height; ++row) {
                std::copy_n(reader.scratch.data() + row * w.width, w.width, to + row * stride_);
            }
            return {};
        };
        return forEachTask(static_cast<int64_t>(windows.size()), makeReader, read);
    }

    Workshop& shop_;
    BlockGrid grid_;
    const HeightSource& source_;
    CoarseMaker coarse_;
    int64_t stride_ = 0;
    std::vector<Post> posts_;
};

}  // namespace

Result<void> makeHeights(Workshop& shop) {
    if (shop.info().format == PostFormat::Int16) return HeightMaker<uint16_t>(shop).run();
    return HeightMaker<float>(shop).run();
}

}  // namespace terray
