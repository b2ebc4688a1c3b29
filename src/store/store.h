// SPDX-License-Identifier: Apache-2.0
// An open store, in a folder or at a URL: manifest, bounds, and readers of its tiles. All that is
// read is compared with the store's hashes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "store/checked_files.h"
#include "store/manifest.h"
#include "tile/tile_source.h"

namespace terray {

/// Whether a source names a store: one that ends in .terray, or a local folder with a manifest.
bool isStore(const std::string& source);

/// const-shared; readers are confined.
class Store final : public TileSource {
public:
    /// Reads manifest and bounds, which may take up to `maxBytes`. Error Input names the file and
    /// what is wrong with it.
    static Result<std::unique_ptr<Store>> open(const std::string& path, uint64_t maxBytes);

    const StoreManifest& manifest() const { return manifest_; }
    /// As it may be shown: a URL without user and query.
    const std::string& path() const { return path_; }
    const TerrainInfo& info() const override { return manifest_.info; }
    uint64_t holes() const override { return manifest_.holes; }
    std::span<const BlockBounds> bounds(int mip) const override {
        return bounds_[static_cast<size_t>(mip)];
    }
    void dropBounds() override { bounds_ = {}; }
    Result<std::unique_ptr<TileReader>> makeReader() const override;
    bool isRemote() const override { return isRemote_; }
    void stopReading() const override { files_->stop(); }
    const StoreFiles& files() const { return *files_; }
    /// Hashes of a mip's edge file.
    const FileHashes& edges(int mip) const { return edges_[static_cast<size_t>(mip)]; }

private:
    Store() = default;
    Result<void> readAllBounds();
    std::string path_;
    bool isRemote_ = false;
    std::unique_ptr<StoreFiles> files_;
    std::vector<FileHashes> edges_;  ///< per mip
    StoreManifest manifest_;
    std::vector<std::vector<BlockBounds>> bounds_;  ///< per mip
};

}  // namespace terray
