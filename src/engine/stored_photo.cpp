// SPDX-License-Identifier: Apache-2.0
// A mip of a store's photo, block by block, into one picture.
#include "engine/stored_photo.h"

#include <algorithm>

#include "base/workers.h"
#include "store/photo_reader.h"

namespace terray {
namespace {

uint64_t mipBytes(const PhotoLayer& layer, int mip) {
    const BlockGrid grid = layer.grid(mip);
    return static_cast<uint64_t>(grid.columns) * static_cast<uint64_t>(grid.rows) * 4;
}

}  // namespace

Result<Photo> loadStoredPhoto(const std::string& store, const PhotoLayer& layer,
                              uint64_t maxBytes) {
    int mip = 0;
    while (mip + 1 < layer.mipCount() && mipBytes(layer, mip) > maxBytes) ++mip;
    const BlockGrid grid = layer.grid(mip);
    Photo photo;
    photo.width = static_cast<int>(grid.columns);
    photo.height = static_cast<int>(grid.rows);
    photo.rgba.resize(mipBytes(layer, mip));
    photo.worldFromPixel = layer.worldFromPixelOf(mip);
    photo.description = layer.description;
    if (mip > 0) photo.description += fmt::format(", reduced 1:{} to fit the memory", 1 << mip);
    struct Worker {
        StorePhotoReader reader;
        std::vector<uint8_t> block;
    };
    const auto makeWorker = [&] {
        return Result<Worker>(
            Worker{StorePhotoReader(store, layer), std::vector<uint8_t>(kPhotoBlockBytes)});
    };
    const auto readShard = [&](Worker& worker, int64_t task) -> Result<void> {
        const int y = static_cast<int>(task / grid.shardsX());
        const int x0 = static_cast<int>(task % grid.shardsX()) * kShardBlocks;
        for (int x = x0; x < std::min(x0 + kShardBlocks, grid.blocksX); ++x) {
            TERRAY_TRY(worker.reader.read(mip, x, y, worker.block.data()));
            const int64_t width = int64_t{grid.widthOf(x)} * 4;
            for (int row = 0; row < grid.heightOf(y); ++row) {
                const int64_t at =
                    (int64_t{y} * kBlockPosts + row) * grid.columns + int64_t{x} * kBlockPosts;
                std::copy_n(worker.block.data() + int64_t{row} * kBlockPosts * 4, width,
                            photo.rgba.data() + at * 4);
            }
        }
        return {};
    };
    TERRAY_TRY(forEachTask(grid.shardCount(), makeWorker, readShard));
    return photo;
}

}  // namespace terray
