// SPDX-License-Identifier: Apache-2.0
// Reading the photo of a store, block by block.
#pragma once

#include <list>
#include <memory>
#include <string>

#include "base/result.h"
#include "store/photo_codec.h"

namespace terray {

/// Open photo files of one thread. confined.
class StorePhotoReader {
public:
    /// `layer` must outlive the reader.
    StorePhotoReader(std::string store, const PhotoLayer& layer)
        : store_(std::move(store)), layer_(layer) {}

    /// Block (x, y) of a mip, kPhotoBlockBytes: 512 x 512 pixels of straight-alpha sRGB, 4 bytes
    /// each; 0 where the photo does not cover and beyond the mip's edge. Error Input names block
    /// and file.
    Result<void> read(int mip, int x, int y, uint8_t* rgba);

private:
    Result<PhotoShardFile*> fileOf(ShardId shard);

    std::string store_;
    const PhotoLayer& layer_;
    std::list<std::pair<ShardId, std::unique_ptr<PhotoShardFile>>> files_;  ///< last used first
};

}  // namespace terray
