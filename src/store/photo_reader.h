// SPDX-License-Identifier: Apache-2.0
// Reading the photo of a store, block by block.
#pragma once

#include <list>
#include <memory>
#include <string>

#include "base/result.h"
#include "store/photo_codec.h"
#include "tile/photo_blocks.h"

namespace terray {

/// Open photo files of one thread. confined.
class StorePhotoReader final : public PhotoBlockReader {
public:
    /// `layer` must outlive the reader.
    StorePhotoReader(std::string store, const PhotoLayer& layer)
        : store_(std::move(store)), layer_(layer) {}

    /// Error Input names block and file.
    Result<void> read(int mip, int x, int y, uint8_t* rgba) override;
    uint64_t bytesRead() const override { return bytesRead_; }

private:
    Result<PhotoShardFile*> fileOf(ShardId shard);

    std::string store_;
    const PhotoLayer& layer_;
    std::list<std::pair<ShardId, std::unique_ptr<PhotoShardFile>>> files_;  ///< last used first
    uint64_t bytesRead_ = 0;
};

/// const-shared; readers are confined.
class StorePhoto final : public PhotoBlockSource {
public:
    StorePhoto(std::string store, PhotoLayer layer)
        : store_(std::move(store)), layer_(std::move(layer)) {}
    PhotoGrid grid() const override { return {layer_.columns, layer_.rows}; }
    const Affine2& worldFromPixel() const override { return layer_.worldFromPixel; }
    const std::string& description() const override { return layer_.description; }
    Result<std::unique_ptr<PhotoBlockReader>> makeReader() const override {
        return std::unique_ptr<PhotoBlockReader>(new StorePhotoReader(store_, layer_));
    }

private:
    std::string store_;
    PhotoLayer layer_;
};

}  // namespace terray
