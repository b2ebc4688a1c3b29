// SPDX-License-Identifier: Apache-2.0
// The last used photo files stay open.
#include "store/photo_reader.h"

#include <algorithm>

#include "base/assert.h"
#include "dataset/pieces.h"
#include "dataset/remote.h"

namespace terray {
namespace {

constexpr size_t kOpenFiles = 4;

}  // namespace

Result<PhotoShardFile*> StorePhotoReader::fileOf(ShardId shard) {
    const auto found = std::find_if(files_.begin(), files_.end(),
                                    [&](const auto& open) { return open.first == shard; });
    if (found != files_.end()) {
        files_.splice(files_.begin(), files_, found);
        return files_.front().second.get();
    }
    const std::string path = gdalName(fileIn(store_, photoShardPath(shard)));
    auto file = PhotoShardFile::open(path, layer_, shard);
    if (!file) return file.error();
    files_.emplace_front(shard, std::move(*file));
    if (files_.size() > kOpenFiles) files_.pop_back();
    return files_.front().second.get();
}

Result<void> StorePhotoReader::read(int mip, int x, int y, uint8_t* rgba) {
    TERRAY_ASSERT(mip >= 0 && mip < layer_.mipCount());
    TERRAY_ASSERT(x >= 0 && x < layer_.grid(mip).blocksX && y >= 0 && y < layer_.grid(mip).blocksY);
    auto file = fileOf({mip, x / kShardBlocks * kShardBlocks, y});
    Result<void> done;
    if (!file) {
        done = file.error();
    } else {
        const uint64_t before = (*file)->bytesRead();
        done = (*file)->read(x, rgba);
        bytesRead_ += (*file)->bytesRead() - before;
    }
    if (done) return {};
    files_.clear();
    FilePieces().forget(fileIn(store_, photoShardPath({mip, x / kShardBlocks * kShardBlocks, y})));
    return makeError(done.error().code,
                     "block ({}, {}) of mip {} of the photo cannot be read: {}; `terray verify {}` "
                     "tells what is damaged",
                     x, y, mip, done.error().message, store_);
}

}  // namespace terray
