// SPDX-License-Identifier: Apache-2.0
// Measuring tiles one by one: mip 0 is decoded once for the errors of all coarser mips.
#include "bake/measure.h"

#include <algorithm>
#include <cmath>

#include "base/workers.h"
#include "kernel/pyramid.h"
#include "store/bounds_file.h"
#include "store/edges.h"
#include "tile/block_bounds.h"
#include "tile/mips.h"

namespace terray {
namespace {

constexpr int kBlockLevel = 6;  ///< of a tile's pyramid: 64 x 64 cells
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// One thread's tools.
struct Tools {
    ShardReaders readers;
    SurfaceComparer comparer;
    std::vector<float> posts;      ///< a slot: kPostStride
    std::vector<uint16_t> codes;   ///< a slot
    std::vector<uint32_t> bounds;  ///< of a pyramid
};

class TileMeasurer {
public:
    TileMeasurer(Workshop& shop, Tools& tools, TileId id)
        : shop_(shop), info_(shop.info()), tools_(tools), id_(id) {
        cellsX_ = info_.scheme.cellsX(id);
        cellsY_ = info_.scheme.cellsY(id);
        column_ = int64_t{id.x} * kTileCells;
        row_ = int64_t{id.y} * kTileCells;
    }

    Result<void> run(Measured& out) {
        auto own = BlockRows::load(shop_.cache, tools_.readers, info_, id_.mip, column_, row_,
                                   cellsX_ + 1, cellsY_ + 1);
        if (!own) return own.error();
        takePosts(*own);
        out.tiles.emplace_back();
        Measured::Tile& tile = out.tiles.back();
        tile.edges = makeEdges();
        measurePyramid(tile);
        for (int y = 0; y * kBlockCells < cellsY_; ++y) {
            measureSteps(tools_.posts.data() + ptrdiff_t{y} * kBlockCells * kPostStride,
                         kPostStride, cellsX_, std::min(kBlockCells, cellsY_ - y * kBlockCells),
                         info_.worldFromLattice, id_.mip,
                         {tile.blocks + y * kTileBlocks, kTileBlocks});
        }
        const int mips = info_.scheme.mipCount();
        if (id_.mip + 1 < mips) TERRAY_TRY(measureToNext(*own, tile));
        if (id_.mip > 0) return {};
        for (int mip = 2; mip < std::min(mips, kLastComparedMip + 1); ++mip) {
            TERRAY_TRY(measureToFinest(*own, mip, out));
        }
        return {};
    }

private:
    void takePosts(const BlockRows& own) {
        tools_.posts.assign(kSlotPosts, kNaN);
        if (info_.format == PostFormat::Int16) tools_.codes.assign(kSlotPosts, kHolePost);
        for (int row = 0; row <= cellsY_; ++row) {
            own.read(row_ + row, column_, cellsX_ + 1,
                     tools_.posts.data() + ptrdiff_t{row} * kPostStride);
            if (info_.format == PostFormat::Float32) continue;
            own.readCodes(row_ + row, column_, cellsX_ + 1,
                          tools_.codes.data() + ptrdiff_t{row} * kPostStride);
        }
    }

    template <class Post>
    void writeEdges(const std::vector<Post>& posts, Post hole, ByteWriter& out) const {
        std::vector<Post> record(kEdgePosts, hole);
        const auto at = [&](int column, int row) {
            return posts[static_cast<size_t>(row * kPostStride + column)];
        };
        for (int k = 0; cellsY_ == kTileCells && k <= cellsX_; ++k) {
            record[static_cast<size_t>(k)] = at(k, kTileCells);
        }
        for (int k = 0; cellsX_ == kTileCells && k < std::min(cellsY_ + 1, kTileCells); ++k) {
            record[static_cast<size_t>(kTilePosts + k)] = at(kTileCells, k);
        }
        for (Post& post : record) {
            if (post != post) post = hole;  // all NaNs are one
        }
        out.raw(record.data(), record.size() * sizeof(Post));
    }

    Bytes makeEdges() const {
        ByteWriter out;
        if (info_.format == PostFormat::Int16) {
            writeEdges(tools_.codes, kHolePost, out);
        } else {
            writeEdges(tools_.posts, kNaN, out);
        }
        return out.take();
    }

    void measurePyramid(Measured::Tile& tile) {
        tools_.bounds.resize(kSlotBounds);
        TileDesc desc{};
        desc.z0 = info_.z0;
        desc.zStep = info_.zStep;
        if (info_.format == PostFormat::Int16) {
            buildPyramid(tools_.codes.data(), cellsX_, cellsY_, desc, tools_.bounds.data());
        } else {
            buildPyramid(tools_.posts.data(), cellsX_, cellsY_, desc, tools_.bounds.data());
        }
        for (uint32_t k = 0; k < kTileBlocks * kTileBlocks; ++k) {
            const uint32_t entry = tools_.bounds[levelOffset(kBlockLevel) + k];
            const auto height = [&](uint32_t code) {
                return std::fma(desc.boundsStep, static_cast<float>(code), desc.boundsZ0);
            };
            setHeights(tile.blocks[k], id_.mip, entry == kEmptyBounds, height(entry & 0xFFFFu),
                       height(entry >> 16));
        }
    }

    /// Compares with `mip`, one row of blocks of at most `side` posts at a time; use(x, y, error)
    /// gets the largest difference in each of them.
    template <class Use>
    Result<void> compare(const BlockRows& own, int mip, int side, const Use& use) {
        const int shift = mip - id_.mip, up = (1 << shift) - 1;
        const int cells = (cellsX_ + up) >> shift;
        auto coarse = BlockRows::load(shop_.cache, tools_.readers, info_, mip, column_ >> shift,
                                      row_ >> shift, cells + 1, ((cellsY_ + up) >> shift) + 1);
        if (!coarse) return coarse.error();
        for (int y = 0; y * side < cellsY_; ++y) {
            const int rows = (std::min(side, cellsY_ - y * side) + up) >> shift;
            const std::span<const float> worst = tools_.comparer.compare(
                *coarse, own, shift, column_ >> shift, (row_ + y * side) >> shift, cells, rows);
            for (int x = 0; x * side < cellsX_; ++x) {
                use(x, y, largestError(worst, x * side, (x + 1) * side));
            }
        }
        return {};
    }

    Result<void> measureToNext(const BlockRows& own, Measured::Tile& tile) {
        return compare(own, id_.mip + 1, kBlockCells, [&](int x, int y, float error) {
            BlockBounds& block = tile.blocks[y * kTileBlocks + x];
            block.errorToNext = withRounding(error, block, 1);
        });
    }

    Result<void> measureToFinest(const BlockRows& own, int mip, Measured& out) {
        const int blockSide = kBlockCells << mip;  // posts of mip 0 across a block of that mip
        const int side = std::min(kTileCells, blockSide);
        return compare(own, mip, side, [&](int x, int y, float error) {
            const int64_t blockX = (column_ + x * side) / blockSide;
            const int64_t blockY = (row_ + y * side) / blockSide;
            out.errors.push_back(
                {static_cast<uint32_t>(mip),
                 static_cast<uint64_t>(blockY * boundsX(info_.scheme, mip) + blockX), error});
        });
    }

    Workshop& shop_;
    const TerrainInfo& info_;
    Tools& tools_;
    TileId id_;
    int cellsX_ = 0, cellsY_ = 0;
    int64_t column_ = 0, row_ = 0;
};

Result<void> tallyBlock(Workshop& shop, Tools& tools, BlockId id, HeightTally& tally) {
    const BlockGrid grid = shop.grid(id.mip);
    const int64_t column = int64_t{id.x} * kBlockPosts, row = int64_t{id.y} * kBlockPosts;
    const int width = grid.widthOf(id.x), height = grid.heightOf(id.y);
    const auto rows =
        BlockRows::load(shop.cache, tools.readers, shop.info(), id.mip, column, row, width, height);
    if (!rows) return rows.error();
    std::vector<float> line(static_cast<size_t>(width));
    for (int k = 0; k < height; ++k) {
        rows->read(row + k, column, width, line.data());
        for (const float z : line) {
            tally.holes += z != z;
            tally.minZ = z < tally.minZ ? z : tally.minZ;
            tally.maxZ = z > tally.maxZ ? z : tally.maxZ;
        }
    }
    return {};
}

Result<void> measureShard(Workshop& shop, Tools& tools, ShardId shard) {
    const TilingScheme& scheme = shop.info().scheme;
    const BlockGrid grid = shop.grid(shard.mip);
    const int blocks = grid.blocksOf(shard);
    Measured measured;
    for (int x = shard.x0; x < shard.x0 + blocks; ++x) {
        if (shard.mip == 0) {
            TERRAY_TRY(tallyBlock(shop, tools, {0, x, shard.y}, measured.tally));
        }
        if (x >= scheme.tilesX(shard.mip) || shard.y >= scheme.tilesY(shard.mip)) continue;
        TERRAY_TRY(TileMeasurer(shop, tools, {shard.mip, x, shard.y}).run(measured));
    }
    TERRAY_TRY(shop.folder.finish(measuredPath(shard), encodeMeasured(measured), {}));
    shop.progress.advance(blocks);
    return {};
}

}  // namespace

void HeightTally::add(const HeightTally& other) {
    minZ = std::min(minZ, other.minZ);
    maxZ = std::max(maxZ, other.maxZ);
    holes += other.holes;
}

std::string measuredPath(ShardId shard) {
    return fmt::format("{}/m{}_y{}_x{}.bin", kMeasuredFolder, shard.mip, shard.y, shard.x0);
}

Bytes encodeMeasured(const Measured& measured) {
    ByteWriter out;
    out.raw(&measured.tally.minZ, sizeof(float));
    out.raw(&measured.tally.maxZ, sizeof(float));
    out.number(measured.tally.holes);
    out.number(static_cast<uint32_t>(measured.tiles.size()));
    for (const Measured::Tile& tile : measured.tiles) {
        out.raw(tile.blocks, sizeof(tile.blocks));
        out.number(static_cast<uint32_t>(tile.edges.size()));
        out.raw(tile.edges.data(), tile.edges.size());
    }
    out.number(static_cast<uint32_t>(measured.errors.size()));
    for (const Measured::CoarseError& error : measured.errors) {
        out.number(error.mip);
        out.number(error.block);
        out.raw(&error.error, sizeof(float));
    }
    return out.take();
}

bool decodeMeasured(std::span<const std::byte> bytes, Measured& measured) {
    ByteReader in(bytes);
    measured = {};
    in.raw(&measured.tally.minZ, sizeof(float));
    in.raw(&measured.tally.maxZ, sizeof(float));
    measured.tally.holes = in.number<uint64_t>();
    const auto tiles = in.number<uint32_t>();
    for (uint32_t k = 0; in.ok() && k < tiles; ++k) {
        Measured::Tile& tile = measured.tiles.emplace_back();
        in.raw(tile.blocks, sizeof(tile.blocks));
        const auto size = in.number<uint32_t>();
        if (!in.ok() || size > in.left()) return false;
        tile.edges.resize(size);
        in.raw(tile.edges.data(), size);
    }
    const auto errors = in.number<uint32_t>();
    for (uint32_t k = 0; in.ok() && k < errors; ++k) {
        Measured::CoarseError error;
        error.mip = in.number<uint32_t>();
        error.block = in.number<uint64_t>();
        in.raw(&error.error, sizeof(float));
        measured.errors.push_back(error);
    }
    return in.ok() && in.left() == 0;
}

/// Columns of shards from top to bottom: what neighbours share is still in the cache, however wide
/// the terrain is.
Result<void> measureAll(Workshop& shop) {
    std::vector<ShardId> missing;
    for (int mip = 0; mip < shop.info().scheme.mipCount(); ++mip) {
        const BlockGrid grid = shop.grid(mip);
        for (int x = 0; x < grid.blocksX; x += kShardBlocks) {
            for (int y = 0; y < grid.blocksY; ++y) {
                const ShardId shard{mip, x, y};
                if (shop.folder.isFinished(measuredPath(shard))) {
                    shop.progress.advance(grid.blocksOf(shard));
                } else {
                    missing.push_back(shard);
                }
            }
        }
    }
    if (missing.empty()) return {};
    const auto makeTools = [&] { return Result<Tools>(Tools{shop.readers(), {}, {}, {}, {}}); };
    const auto measure = [&](Tools& tools, int64_t task) {
        return measureShard(shop, tools, missing[static_cast<size_t>(task)]);
    };
    return forEachTask(static_cast<int64_t>(missing.size()), makeTools, measure);
}

}  // namespace terray
