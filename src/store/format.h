// SPDX-License-Identifier: Apache-2.0
// Names, numbers and sizes of the store's parts: docs/store.md in code.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "tile/terrain_info.h"

namespace terray {

constexpr int kStoreVersion = 1;
constexpr int kBlockPosts = kTileCells;  ///< posts a side of a block on disk
constexpr size_t kBlockSamples = size_t{kBlockPosts} * kBlockPosts;
constexpr int kShardBlocks = 8;  ///< blocks of one height file: a run in a row of blocks
constexpr int kEdgePosts = kTilePosts + kTileCells;  ///< of a tile: 513th row, then 513th column
constexpr int kBoundsBands = 8;

constexpr const char* kManifestName = "terrain.json";
constexpr const char* kHashesName = "hashes.bin";
constexpr const char* kHeightVrtName = "height.vrt";

/// One height file: blocks [x0, x0 + count) of row y of a mip's blocks.
struct ShardId {
    int mip = 0, x0 = 0, y = 0;
    friend auto operator<=>(const ShardId&, const ShardId&) = default;
};

/// Blocks and shards on disk. Where a side has 512 n + 1 posts there is one more block than tiles:
/// it holds the last post alone.
struct BlockGrid {
    int64_t columns = 0, rows = 0;  ///< posts of the mip
    int blocksX = 0, blocksY = 0;

    BlockGrid(const TilingScheme& scheme, int mip)
        : BlockGrid(scheme.columnsAt(mip), scheme.rowsAt(mip)) {}
    BlockGrid(int64_t width, int64_t height) : columns(width), rows(height) {
        blocksX = static_cast<int>((columns + kBlockPosts - 1) / kBlockPosts);
        blocksY = static_cast<int>((rows + kBlockPosts - 1) / kBlockPosts);
    }
    int shardsX() const { return (blocksX + kShardBlocks - 1) / kShardBlocks; }
    int64_t shardCount() const { return int64_t{shardsX()} * blocksY; }
    /// Posts of a block or a shard, smaller at the right and lower end.
    int widthOf(int x, int blocks = 1) const {
        return static_cast<int>(
            std::min<int64_t>(columns - int64_t{x} * kBlockPosts, int64_t{blocks} * kBlockPosts));
    }
    int heightOf(int y) const { return widthBelow(rows, y); }
    int blocksOf(ShardId shard) const { return std::min(kShardBlocks, blocksX - shard.x0); }

private:
    static int widthBelow(int64_t posts, int index) {
        return static_cast<int>(
            std::min<int64_t>(posts - int64_t{index} * kBlockPosts, kBlockPosts));
    }
};

/// Paths inside the store, with '/'.
std::string shardPath(ShardId shard);
std::string edgesPath(int mip);
std::string boundsPath(int mip);
std::string mipVrtPath(int mip);

/// Size of an edge file: header, then one record a tile.
constexpr uint64_t kEdgeHeaderBytes = 32;
inline uint64_t postBytes(PostFormat format) { return format == PostFormat::Int16 ? 2 : 4; }
inline uint64_t edgeRecordBytes(PostFormat format) { return kEdgePosts * postBytes(format); }

/// Place of a tile in a list of all tiles of its mip.
inline int64_t tileIndex(const TilingScheme& scheme, TileId id) {
    return int64_t{id.y} * scheme.tilesX(id.mip) + id.x;
}

/// Map from pixel corners to the CRS (in its units) for a raster whose pixel (0, 0) is post
/// (column, row) of a mip: GDAL's six numbers.
struct GeoTransform {
    double values[6];
};
GeoTransform geoTransformOf(const TerrainInfo& info, int mip, int64_t column, int64_t row);

}  // namespace terray
