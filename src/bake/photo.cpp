// SPDX-License-Identifier: Apache-2.0
// The photo: mip 0 in batches of rows of blocks, read and encoded on all cores; coarser mips from
// the decoded pixels of the next finer one.
#include <algorithm>
#include <mutex>

#include "bake/workshop.h"
#include "base/workers.h"
#include "store/photo_reader.h"
#include "store/vrt.h"
#include "tile/photo_mips.h"

namespace terray {
namespace {

constexpr int kPhotoShare = 3;     ///< of the memory budget
constexpr int kFilesOfThread = 4;  ///< in a batch

/// Readers keep their place in the file from batch to batch. synchronised.
class ReaderPool {
public:
    explicit ReaderPool(const PhotoSource& source) : source_(source) {}
    Result<std::unique_ptr<PhotoReader>> take() {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                std::unique_ptr<PhotoReader> reader = std::move(idle_.back());
                idle_.pop_back();
                return reader;
            }
        }
        return source_.makeReader();
    }
    void giveBack(std::unique_ptr<PhotoReader> reader) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(reader));
    }

private:
    const PhotoSource& source_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<PhotoReader>> idle_;
};

/// A reader that goes back to its pool.
struct LentReader {
    ReaderPool* pool;
    std::unique_ptr<PhotoReader> reader;
    LentReader(ReaderPool& from, std::unique_ptr<PhotoReader> taken)
        : pool(&from), reader(std::move(taken)) {}
    LentReader(LentReader&&) noexcept = default;
    LentReader& operator=(LentReader&&) = delete;
    ~LentReader() {
        if (reader) pool->giveBack(std::move(reader));
    }
};

class PhotoMaker {
public:
    explicit PhotoMaker(Workshop& shop)
        : shop_(shop),
          layer_(*shop.plan.manifest.photo),
          source_(*shop.plan.photo),
          readers_(source_),
          grid_(layer_.grid(0)) {}

    Result<void> run() {
        const int64_t blockBytes = static_cast<int64_t>(kPhotoBlockBytes);
        const int64_t blocks = std::max<int64_t>(
            static_cast<int64_t>(shop_.plan.memoryBytes) / kPhotoShare / blockBytes, kShardBlocks);
        // enough files for all cores, and not so many that a stopped bake has lost much
        const int files = kFilesOfThread * tbb::this_task_arena::max_concurrency();
        const int64_t enough = (files + grid_.shardsX() - 1) / grid_.shardsX();
        const auto rows = static_cast<int>(std::clamp<int64_t>(blocks / grid_.blocksX, 1, enough));
        const int columns = static_cast<int>(
            std::min<int64_t>(blocks / kShardBlocks * kShardBlocks, grid_.blocksX));
        for (int y = 0; y < grid_.blocksY; y += rows) {
            for (int x = 0; x < grid_.blocksX; x += columns) {
                TERRAY_TRY(makeBatch(x, std::min(x + columns, grid_.blocksX), y,
                                     std::min(y + rows, grid_.blocksY)));
            }
        }
        pixels_ = {};
        for (int mip = 1; mip < layer_.mipCount(); ++mip) TERRAY_TRY(makeCoarse(mip));
        return finishVrts();
    }

private:
    /// Those of a list that are not finished yet.
    std::vector<ShardId> missingOf(const std::vector<ShardId>& shards, const BlockGrid& grid) {
        std::vector<ShardId> missing;
        for (const ShardId shard : shards) {
            if (shop_.folder.isFinished(photoShardPath(shard))) {
                shop_.progress.advance(grid.blocksOf(shard));
            } else {
                missing.push_back(shard);
            }
        }
        return missing;
    }

    Result<void> makeBatch(int x0, int x1, int y0, int y1) {
        std::vector<ShardId> missing = missingOf(shardsIn(x0, x1, y0, y1), grid_);
        if (missing.empty()) return {};
        stride_ = int64_t{grid_.widthOf(x0, x1 - x0)} * 4;
        const int64_t top = int64_t{y0} * kBlockPosts, left = int64_t{x0} * kBlockPosts;
        const int64_t rows = int64_t{y1 - 1 - y0} * kBlockPosts + grid_.heightOf(y1 - 1);
        pixels_.resize(static_cast<size_t>(stride_ * rows));
        const auto placeOf = [&](int64_t column, int64_t row) {
            return pixels_.data() + (row - top) * stride_ + (column - left) * 4;
        };
        const std::vector<Window> windows = windowsOf(missing, left, stride_ / 4);
        const auto lend = [&]() -> Result<LentReader> {
            auto reader = readers_.take();
            if (!reader) return reader.error();
            return LentReader(readers_, std::move(*reader));
        };
        const auto read = [&](LentReader& lent, int64_t task) -> Result<void> {
            const Window& w = windows[static_cast<size_t>(task)];
            return lent.reader->read(w.column, w.row, w.width, w.height, placeOf(w.column, w.row),
                                     stride_);
        };
        TERRAY_TRY(forEachTask(static_cast<int64_t>(windows.size()), lend, read));
        const auto makeNothing = [] { return Result<int>(0); };
        const auto encode = [&](int&, int64_t task) {
            const ShardId shard = missing[static_cast<size_t>(task)];
            return finish(shard, grid_,
                          placeOf(int64_t{shard.x0} * kBlockPosts, int64_t{shard.y} * kBlockPosts),
                          stride_);
        };
        return forEachTask(static_cast<int64_t>(missing.size()), makeNothing, encode);
    }

    std::vector<ShardId> shardsIn(int x0, int x1, int y0, int y1) const {
        std::vector<ShardId> shards = shardsOf(grid_, 0, y0, y1);
        std::erase_if(shards, [&](ShardId shard) { return shard.x0 < x0 || shard.x0 >= x1; });
        return shards;
    }

    /// Windows that follow the source's own blocks; only rows that a missing file needs.
    std::vector<Window> windowsOf(const std::vector<ShardId>& missing, int64_t left,
                                  int64_t width) const {
        const int64_t preferred = std::clamp<int64_t>(source_.preferredRows(), 1, kBlockPosts);
        const int64_t wide = preferred >= kTallRows ? kReadColumns : width;
        std::vector<Window> windows;
        for (size_t k = 0; k < missing.size(); ++k) {
            if (k > 0 && missing[k].y == missing[k - 1].y) continue;
            const int64_t top = int64_t{missing[k].y} * kBlockPosts;
            const int64_t bottom = top + grid_.heightOf(missing[k].y);
            for (int64_t row = top; row < bottom; row += preferred) {
                for (int64_t column = 0; column < width; column += wide) {
                    windows.push_back({left + column, row, std::min(wide, width - column),
                                       std::min(preferred, bottom - row)});
                }
            }
        }
        return windows;
    }

    Result<void> finish(ShardId shard, const BlockGrid& grid, const uint8_t* rgba,
                        int64_t stride) const {
        auto encoded = encodePhotoShard(shop_.info(), layer_, shard, rgba, stride);
        if (!encoded) return encoded.error();
        TERRAY_TRY(
            shop_.folder.finish(photoShardPath(shard), encoded->bytes, std::move(encoded->blocks)));
        shop_.progress.advance(grid.blocksOf(shard));
        return {};
    }

    Result<void> makeCoarse(int mip) {
        const BlockGrid grid = layer_.grid(mip), finer = layer_.grid(mip - 1);
        const std::vector<ShardId> missing = missingOf(shardsOf(grid, mip, 0, grid.blocksY), grid);
        struct Worker {
            StorePhotoReader reader;
            std::vector<uint8_t> fine, coarse;
        };
        const auto makeWorker = [&] {
            return Result<Worker>(Worker{StorePhotoReader(shop_.folder.path(), layer_),
                                         std::vector<uint8_t>(kPhotoBlockBytes),
                                         {}});
        };
        const auto make = [&](Worker& worker, int64_t task) -> Result<void> {
            const ShardId shard = missing[static_cast<size_t>(task)];
            const int64_t width = grid.widthOf(shard.x0, grid.blocksOf(shard));
            worker.coarse.resize(static_cast<size_t>(width * 4 * grid.heightOf(shard.y)));
            for (int y = 2 * shard.y; y < std::min(2 * shard.y + 2, finer.blocksY); ++y) {
                const int end = std::min(2 * (shard.x0 + kShardBlocks), finer.blocksX);
                for (int x = 2 * shard.x0; x < end; ++x) {
                    TERRAY_TRY(worker.reader.read(mip - 1, x, y, worker.fine.data()));
                    uint8_t* to =
                        worker.coarse.data() + (y % 2 * (kBlockPosts / 2) * width +
                                                int64_t{x - 2 * shard.x0} * (kBlockPosts / 2)) *
                                                   4;
                    halvePhoto(worker.fine.data(), finer.widthOf(x), finer.heightOf(y),
                               kBlockPosts * 4, to, width * 4);
                }
            }
            return finish(shard, grid, worker.coarse.data(), width * 4);
        };
        return forEachTask(static_cast<int64_t>(missing.size()), makeWorker, make);
    }

    Result<void> finishVrts() {
        for (int mip = 0; mip < layer_.mipCount(); ++mip) {
            const auto text = photoVrtText(shop_.info(), layer_, mip);
            if (!text) return text.error();
            TERRAY_TRY(shop_.folder.finish(mip == 0 ? kPhotoVrtName : photoMipVrtPath(mip),
                                           bytesOf(*text), {}));
        }
        return {};
    }

    Workshop& shop_;
    const PhotoLayer& layer_;
    const PhotoSource& source_;
    ReaderPool readers_;
    BlockGrid grid_;
    int64_t stride_ = 0;
    std::vector<uint8_t> pixels_;
};

}  // namespace

Result<void> makePhoto(Workshop& shop) {
    if (shop.plan.photo == nullptr) return {};
    return PhotoMaker(shop).run();
}

std::vector<std::string> photoFiles(const PhotoLayer& layer) {
    std::vector<std::string> files;
    for (int mip = 0; mip < layer.mipCount(); ++mip) {
        const BlockGrid grid = layer.grid(mip);
        for (const ShardId shard : shardsOf(grid, mip, 0, grid.blocksY)) {
            files.push_back(photoShardPath(shard));
        }
    }
    for (int mip = 1; mip < layer.mipCount(); ++mip) files.push_back(photoMipVrtPath(mip));
    files.push_back(kPhotoVrtName);
    return files;
}

double photoBlockCount(const PhotoLayer& layer) {
    double blocks = 0;
    for (int mip = 0; mip < layer.mipCount(); ++mip) {
        blocks += static_cast<double>(layer.grid(mip).blocksX) * layer.grid(mip).blocksY;
    }
    return blocks;
}

}  // namespace terray
