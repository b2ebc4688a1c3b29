// SPDX-License-Identifier: Apache-2.0
// Opening a store, and reading its tiles one at a time.
#include "store/store.h"

#include <cpl_vsi.h>

#include <algorithm>
#include <list>

#include "base/assert.h"
#include "dataset/gdal_handle.h"
#include "store/bounds_file.h"
#include "store/edges.h"
#include "store/files.h"
#include "store/format.h"
#include "store/shard_codec.h"
#include "tile/codes.h"

namespace terray {
namespace {

constexpr uint64_t kMostManifestBytes = uint64_t{256} << 20;
constexpr size_t kOpenShards = 4;  ///< of a reader

std::string joined(const std::string& folder, const std::string& name) {
    return folder + (folder.ends_with('/') ? "" : "/") + name;
}

bool exists(const std::string& path) {
    VSIStatBufL stat;
    return VSIStatExL(path.c_str(), &stat, VSI_STAT_EXISTS_FLAG) == 0;
}

/// confined.
class StoreTileReader final : public TileReader {
public:
    explicit StoreTileReader(const Store& store) : store_(store), info_(store.info()) {}

    Result<void> read(TileId id, float* posts, ptrdiff_t stride) override {
        if (info_.format == PostFormat::Float32) return readTile(id, posts, stride, floats_);
        tile_.resize(size_t{kTilePosts} * kTilePosts);
        TERRAY_TRY(readCodes(id, tile_.data(), kTilePosts));
        for (int row = 0; row <= info_.scheme.cellsY(id); ++row) {
            decodeCodes(tile_.data() + row * kTilePosts, info_.scheme.cellsX(id) + 1, info_.z0,
                        info_.zStep, posts + row * stride);
        }
        return {};
    }
    Result<void> readCodes(TileId id, uint16_t* codes, ptrdiff_t stride) override {
        return readTile(id, codes, stride, codes_);
    }
    uint64_t bytesRead() const override { return bytesRead_; }

private:
    template <class Post>
    Result<void> readTile(TileId id, Post* posts, ptrdiff_t stride, std::vector<Post>& scratch) {
        const Result<void> done = fill(id, posts, stride, scratch);
        if (done) return {};
        return makeError(
            done.error().code,
            "tile ({}, {}) of mip {} cannot be read: {}; `terray verify {}` tells what "
            "is damaged",
            id.x, id.y, id.mip, done.error().message, store_.path());
    }

    template <class Post>
    Result<void> fill(TileId id, Post* posts, ptrdiff_t stride, std::vector<Post>& scratch) {
        const TilingScheme& scheme = info_.scheme;
        TERRAY_ASSERT(id.mip >= 0 && id.mip < scheme.mipCount());
        auto shard = shardOf({id.mip, id.x / kShardBlocks * kShardBlocks, id.y});
        if (!shard) return shard.error();
        scratch.resize(size_t{kBlockPosts} * kBlockPosts);
        const uint64_t before = (*shard)->bytesRead();
        TERRAY_TRY((*shard)->read(id.x, scratch.data()));
        bytesRead_ += (*shard)->bytesRead() - before;
        const int cellsX = scheme.cellsX(id), cellsY = scheme.cellsY(id);
        const int width = std::min(cellsX + 1, kBlockPosts);
        const int height = std::min(cellsY + 1, kBlockPosts);
        for (int row = 0; row < height; ++row) {
            std::copy_n(scratch.data() + row * kBlockPosts, width, posts + row * stride);
        }
        if (cellsX < kTileCells && cellsY < kTileCells) return {};
        return fillEdges(id, posts, stride, scratch);
    }

    template <class Post>
    Result<void> fillEdges(TileId id, Post* posts, ptrdiff_t stride, std::vector<Post>& scratch) {
        auto file = edgesOf(id.mip);
        if (!file) return file.error();
        const BlockRange range = edgeRange(info_, id);
        scratch.resize(kEdgePosts);
        TERRAY_ASSERT(range.size == kEdgePosts * sizeof(Post));
        if (VSIFSeekL(*file, range.offset, SEEK_SET) != 0 ||
            VSIFReadL(scratch.data(), 1, range.size, *file) != range.size) {
            return makeError(ErrorCode::Input, "'{}' is too short", edgesPath(id.mip));
        }
        bytesRead_ += range.size;
        const int cellsX = info_.scheme.cellsX(id), cellsY = info_.scheme.cellsY(id);
        if (cellsY == kTileCells) {
            std::copy_n(scratch.data(), cellsX + 1, posts + kTileCells * stride);
        }
        if (cellsX == kTileCells) {
            for (int row = 0; row < std::min(cellsY + 1, kTileCells); ++row) {
                posts[row * stride + kTileCells] = scratch[static_cast<size_t>(kTilePosts + row)];
            }
        }
        return {};
    }

    Result<ShardFile*> shardOf(ShardId id) {
        const auto found = std::find_if(shards_.begin(), shards_.end(),
                                        [&](const auto& open) { return open.first == id; });
        if (found != shards_.end()) {
            shards_.splice(shards_.begin(), shards_, found);
            return shards_.front().second.get();
        }
        auto file = openShard(store_.path(), store_.manifest(), id);
        if (!file) return file.error();
        shards_.emplace_front(id, std::move(*file));
        if (shards_.size() > kOpenShards) shards_.pop_back();
        return shards_.front().second.get();
    }

    Result<VSILFILE*> edgesOf(int mip) {
        if (edges_ && edgesMip_ == mip) return edges_.get();
        clearGdalMessage();
        const std::string path = joined(store_.path(), edgesPath(mip));
        edges_.reset(VSIFOpenL(path.c_str(), "rb"));
        edgesMip_ = mip;
        const Bytes expected = encodeEdgeHeader(info_, mip);
        Bytes header(expected.size());
        if (!edges_ || VSIFReadL(header.data(), 1, header.size(), edges_.get()) != header.size() ||
            header != expected) {
            edges_.reset();
            return makeError(ErrorCode::Input, "'{}' is missing or damaged", path);
        }
        return edges_.get();
    }

    struct Close {
        void operator()(VSILFILE* file) const { VSIFCloseL(file); }
    };
    const Store& store_;
    const TerrainInfo& info_;
    std::list<std::pair<ShardId, std::unique_ptr<ShardFile>>> shards_;  ///< last used first
    std::unique_ptr<VSILFILE, Close> edges_;
    int edgesMip_ = -1;
    uint64_t bytesRead_ = 0;
    std::vector<float> floats_;
    std::vector<uint16_t> codes_, tile_;
};

}  // namespace

bool isStore(const std::string& source) {
    ensureGdal();
    std::string name = source;
    while (name.ends_with('/')) name.pop_back();
    if (name.ends_with(".terray")) return true;
    return !name.starts_with("/vsi") && exists(joined(source, kManifestName));
}

Result<std::unique_ptr<Store>> Store::open(const std::string& path, uint64_t maxBytes) {
    ensureGdal();
    const std::string manifestPath = joined(path, kManifestName);
    if (!exists(manifestPath)) {
        return makeError(ErrorCode::Input,
                         "'{}' is not a store: it has no {}; `terray bake` makes one", path,
                         kManifestName);
    }
    const auto bytes = readFile(manifestPath, kMostManifestBytes);
    if (!bytes) return bytes.error();
    auto manifest =
        parseManifest(manifestPath, {reinterpret_cast<const char*>(bytes->data()), bytes->size()});
    if (!manifest) return manifest.error();
    std::unique_ptr<Store> store(new Store);
    store->path_ = path;
    store->manifest_ = std::move(*manifest);
    store->manifest_.info.name = path;
    if (const auto& source = store->manifest_.inPlace) {
        TERRAY_TRY(checkInPlace(*source, store->manifest_.sources[0], path));
    }
    const TerrainInfo& info = store->info();
    const TilingScheme& scheme = info.scheme;
    double boundsBytes = 0;
    for (int mip = 0; mip < scheme.mipCount(); ++mip) {
        boundsBytes += static_cast<double>(scheme.tilesX(mip)) * scheme.tilesY(mip) *
                       (kTileBlocks * kTileBlocks * sizeof(BlockBounds));
    }
    if (boundsBytes > static_cast<double>(maxBytes)) {
        return makeError(ErrorCode::Input,
                         "the bounds of '{}' need {:.2f} GiB of memory, but only {:.2f} GiB may be "
                         "used; raise --memory",
                         path, boundsBytes / 0x1p30, static_cast<double>(maxBytes) / 0x1p30);
    }
    for (int mip = 0; mip < info.scheme.mipCount(); ++mip) {
        auto bounds = readBounds(joined(path, boundsPath(mip)), info, mip);
        if (!bounds) return bounds.error();
        store->bounds_.push_back(std::move(*bounds));
    }
    return store;
}

Result<std::unique_ptr<TileReader>> Store::makeReader() const {
    return std::unique_ptr<TileReader>(new StoreTileReader(*this));
}

}  // namespace terray
