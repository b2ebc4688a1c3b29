// SPDX-License-Identifier: Apache-2.0
// Opening a store, and reading its tiles one at a time.
#include "store/store.h"

#include <cpl_vsi.h>

#include <algorithm>
#include <list>

#include "base/assert.h"
#include "dataset/gdal_handle.h"
#include "dataset/remote.h"
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

bool exists(const std::string& path) {
    VSIStatBufL stat;
    return VSIStatExL(gdalName(path).c_str(), &stat, VSI_STAT_EXISTS_FLAG) == 0;
}

/// confined.
class StoreTileReader final : public TileReader {
public:
    explicit StoreTileReader(const Store& store)
        : store_(store), info_(store.info()), reader_(store.files()) {}

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
    uint64_t bytesRead() const override { return reader_.bytesRead() + bytesInPlace_; }

private:
    template <class Post>
    Result<void> readTile(TileId id, Post* posts, ptrdiff_t stride, std::vector<Post>& scratch) {
        const Result<void> done = fill(id, posts, stride, scratch);
        if (done || done.error().code == ErrorCode::Interrupted) return done;
        const std::string advice =
            store_.isRemote()
                ? std::string("run again when the server is well")
                : fmt::format("`terray verify {}` tells what is damaged", store_.path());
        return makeError(done.error().code, "tile ({}, {}) of mip {} cannot be read: {}; {}", id.x,
                         id.y, id.mip, done.error().message, advice);
    }

    template <class Post>
    Result<void> fill(TileId id, Post* posts, ptrdiff_t stride, std::vector<Post>& scratch) {
        const TilingScheme& scheme = info_.scheme;
        TERRAY_ASSERT(id.mip >= 0 && id.mip < scheme.mipCount());
        auto shard = shardOf({id.mip, id.x / kShardBlocks * kShardBlocks, id.y});
        if (!shard) return shard.error();
        const OpenShard& open = **shard;
        scratch.resize(size_t{kBlockPosts} * kBlockPosts);
        if (open.image) {
            TERRAY_TRY(reader_.need(*open.image, static_cast<size_t>(id.x - open.id.x0)));
        }
        const uint64_t before = open.file->bytesRead();
        TERRAY_TRY(open.file->read(id.x, scratch.data()));
        if (!open.image) bytesInPlace_ += open.file->bytesRead() - before;
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
        scratch.resize(kEdgePosts);
        const auto record = static_cast<size_t>(tileIndex(info_.scheme, id));
        TERRAY_TRY(
            reader_.read(store_.edges(id.mip), record, std::as_writable_bytes(std::span(scratch))));
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

    /// The image holds what has been read of the file, and lives longer; none of a source in place.
    struct OpenShard {
        ShardId id;
        std::unique_ptr<FileImage> image;
        std::unique_ptr<ShardFile> file;
    };

    Result<OpenShard*> shardOf(ShardId id) {
        const auto found = std::find_if(shards_.begin(), shards_.end(),
                                        [&](const OpenShard& open) { return open.id == id; });
        if (found != shards_.end()) {
            shards_.splice(shards_.begin(), shards_, found);
            return &shards_.front();
        }
        OpenShard open{id, nullptr, nullptr};
        if (id.mip > 0 || !store_.manifest().inPlace) {
            auto image = reader_.open(shardPath(id));
            if (!image) return image.error();
            open.image = std::move(*image);
        }
        auto file = open.image ? ShardFile::open(open.image->path(), info_, id)
                               : openShard(store_.files().folder(), store_.manifest(), id);
        if (!file) return file.error();
        open.file = std::move(*file);
        shards_.push_front(std::move(open));
        if (shards_.size() > kOpenShards) shards_.pop_back();
        return &shards_.front();
    }

    const Store& store_;
    const TerrainInfo& info_;
    CheckedReader reader_;
    uint64_t bytesInPlace_ = 0;    ///< read of the source itself
    std::list<OpenShard> shards_;  ///< last used first
    std::vector<float> floats_;
    std::vector<uint16_t> codes_, tile_;
};

/// A folder or URL without what may follow its name.
std::string bareName(const std::string& source) {
    std::string name = source;
    if (!httpUrl(source).empty()) name = name.substr(0, name.find('?'));
    while (name.ends_with('/')) name.pop_back();
    return name;
}

uint64_t boundsBytes(const TilingScheme& scheme) {
    double bytes = 0;
    for (int mip = 0; mip < scheme.mipCount(); ++mip) {
        bytes += static_cast<double>(scheme.tilesX(mip)) * scheme.tilesY(mip) *
                 (kTileBlocks * kTileBlocks * sizeof(BlockBounds));
    }
    return static_cast<uint64_t>(std::min(bytes, 0x1p63));
}

Result<StoreManifest> readManifest(const std::string& path, FilePieces& pieces) {
    const std::string manifestPath = fileIn(path, kManifestName);
    if (!isRemote(path) && !exists(manifestPath)) {
        return makeError(ErrorCode::Input,
                         "'{}' is not a store: it has no {}; `terray bake` makes one", path,
                         kManifestName);
    }
    const auto bytes = pieces.readAll(manifestPath, kMostManifestBytes);
    if (!bytes) {
        if (bytes.error().code == ErrorCode::Interrupted || !isRemote(path)) return bytes.error();
        return makeError(
            ErrorCode::Input,
            "'{}' is not a store or out of reach now: {}; check the URL, then run again",
            shownName(path), bytes.error().message);
    }
    auto manifest = parseManifest(shownName(manifestPath),
                                  {reinterpret_cast<const char*>(bytes->data()), bytes->size()});
    if (!manifest) pieces.forget(manifestPath);
    return manifest;
}

}  // namespace

bool isStore(const std::string& source) {
    ensureGdal();
    const std::string name = bareName(source);
    if (name.ends_with(".terray")) return true;
    return !isRemote(name) && !name.starts_with("/vsi") && exists(fileIn(name, kManifestName));
}

Result<std::unique_ptr<Store>> Store::open(const std::string& path, uint64_t maxBytes) {
    ensureGdal();
    FilePieces pieces;
    auto manifest = readManifest(path, pieces);
    if (!manifest) return manifest.error();
    std::unique_ptr<Store> store(new Store);
    store->path_ = shownName(path);
    store->isRemote_ = terray::isRemote(path);
    store->manifest_ = std::move(*manifest);
    store->manifest_.info.name = store->path_;
    if (const auto& source = store->manifest_.inPlace) {
        if (store->isRemote_) {
            return makeError(ErrorCode::Input,
                             "'{}' uses '{}' in place, which is out of reach over the network; "
                             "bake it without --in-place",
                             store->path_, source->path);
        }
        TERRAY_TRY(checkInPlace(*source, store->manifest_.sources[0], path));
    }
    auto files = StoreFiles::open(path, pieces, store->manifest_.hashes);
    if (!files) return files.error();
    store->files_ = std::move(*files);
    const TilingScheme& scheme = store->info().scheme;
    const uint64_t needed = boundsBytes(scheme);
    if (needed > maxBytes) {
        return makeError(ErrorCode::Input,
                         "the bounds of '{}' need {:.2f} GiB of memory, but only {:.2f} GiB may be "
                         "used; raise --memory",
                         store->path_, static_cast<double>(needed) / 0x1p30,
                         static_cast<double>(maxBytes) / 0x1p30);
    }
    TERRAY_TRY(store->readAllBounds());
    for (int mip = 0; mip < scheme.mipCount(); ++mip) {
        auto edges = store->files_->hashesOf(edgesPath(mip));
        if (!edges) return edges.error();
        const bool isWhole = edges->blocks == edgeRanges(store->info(), mip);
        if (!isWhole) {
            return makeError(ErrorCode::Input, "'{}' does not fit to {}; bake it again",
                             store->path_, kManifestName);
        }
        store->edges_.push_back(std::move(*edges));
    }
    return store;
}

Result<void> Store::readAllBounds() {
    CheckedReader reader(*files_);
    for (int mip = 0; mip < info().scheme.mipCount(); ++mip) {
        auto bytes = reader.readAll(boundsPath(mip));
        if (!bytes) return bytes.error();
        auto bounds = readBounds(boundsPath(mip), *bytes, info(), mip);
        if (!bounds) return bounds.error();
        bounds_.push_back(std::move(*bounds));
    }
    return {};
}

Result<std::unique_ptr<TileReader>> Store::makeReader() const {
    return std::unique_ptr<TileReader>(new StoreTileReader(*this));
}

}  // namespace terray
