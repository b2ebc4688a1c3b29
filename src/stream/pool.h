// SPDX-License-Identifier: Apache-2.0
// The slots of a terrain in memory: one mapping that holds the posts of the resident tiles, then
// their pyramids; and the page table of all tiles. Pages that nothing is written to cost no memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/result.h"
#include "kernel/pyramid.h"
#include "stream/resident.h"
#include "tile/mips.h"
#include "tile/tile_source.h"

namespace terray {

/// Kernels gather with signed 32-bit byte offsets from the middle of a pool.
constexpr uint64_t kLargestPoolBytes = uint64_t{4} << 30;

/// Bytes of all posts, and of all pyramids, of a terrain.
struct PoolSizes {
    double slots = 0, postBytes = 0, boundBytes = 0, tableBytes = 0;
    double total() const { return postBytes + boundBytes + tableBytes; }
};
PoolSizes poolSizes(const TerrainInfo& info);
/// The same with slots for some of the tiles only.
PoolSizes poolSizes(const TerrainInfo& info, double slots);

constexpr size_t kBlocksPerTile = size_t{kTileBlocks} * kTileBlocks;

/// Tiles are numbered: those of mip 0 row by row, then those of mip 1, and so on. Where all are
/// resident a tile's slot is its number.
struct ResidentTerrain::Pool {
    /// A slot for every tile.
    static Result<std::unique_ptr<Pool>> make(const TerrainInfo& info);
    /// That many slots, all free.
    static Result<std::unique_ptr<Pool>> makeFree(const TerrainInfo& info, uint32_t slots);
    ~Pool();
    Pool(const Pool&) = delete;
    Pool& operator=(const Pool&) = delete;

    TilingScheme scheme;
    Affine2 worldFromLattice;
    PostFormat format = PostFormat::Float32;
    int mips = 0;
    int firstKept = 0;                   ///< tiles of this mip and coarser ones are always resident
    std::vector<uint32_t> firstTile;     ///< per mip
    std::vector<uint32_t> slots;         ///< per tile: kNoSlot if it is not resident
    std::vector<BlockBounds> blocks;     ///< 64 per tile
    std::vector<uint8_t> hollow;         ///< per tile: without cells, never loaded; none if whole
    std::vector<TileDesc> tiles;         ///< per slot
    std::vector<TileId> ids;             ///< per slot; mip -1 if it is free
    std::vector<SlotBounds> slotBounds;  ///< per slot
    std::vector<uint8_t> sharpness;      ///< kSlotSharpness per slot
    void* posts = nullptr;               ///< uint16_t or float
    uint32_t* bounds = nullptr;

    bool isWhole() const { return tiles.size() == slots.size(); }
    uint32_t numberOf(TileId id) const;  ///< kNoSlot outside
    TileId tileOf(uint32_t number) const;
    uint32_t slotOf(TileId id) const;  ///< kNoSlot outside, or if it is not resident
    std::span<const BlockBounds> blocksOf(uint32_t number) const {
        return {blocks.data() + number * kBlocksPerTile, kBlocksPerTile};
    }
    bool isHollow(uint32_t number) const { return !hollow.empty() && hollow[number] != 0; }
    /// Resident, or nothing to load.
    bool isHere(uint32_t number) const { return slots[number] != kNoSlot || isHollow(number); }
    /// Bounds of all blocks, and which tiles have no cells.
    void takeBlocks(const TileSource& source);
    /// Gives a slot to a tile; the page table does not know of it yet.
    void assign(uint32_t slot, TileId id);
    /// Cells of a tile inside its mip, 1..512 a side.
    int cellsX(TileId id) const;
    int cellsY(TileId id) const;
    template <class Post>
    Post* postsOf(uint32_t slot) const {
        return static_cast<Post*>(posts) + tiles[slot].posts;
    }
    /// Decoded posts [column, column + count) of a row of a slot.
    void decodeRow(uint32_t slot, int row, int column, int count, float* out) const;
    /// Writes a row of heights into a slot; returned codes are rounded to the nearest.
    void encodeRow(uint32_t slot, int row, const float* heights, int count) const;

private:
    Pool() = default;
    static std::unique_ptr<Pool> makeTable(const TerrainInfo& info);
    void addSlots(uint32_t count);
    Result<void> map();
    float z0_ = 0, zStep_ = 0;
    void* mapping_ = nullptr;
    size_t mappingBytes_ = 0;
};

/// The posts of a whole mip, read from its slots.
class MipRows final : public PostRows {
public:
    MipRows(const ResidentTerrain::Pool& pool, int mip) : pool_(pool), mip_(mip) {}
    int64_t columns() const override { return pool_.scheme.columnsAt(mip_); }
    int64_t rows() const override { return pool_.scheme.rowsAt(mip_); }
    void read(int64_t row, int64_t column, int64_t count, float* out) const override;

private:
    const ResidentTerrain::Pool& pool_;
    int mip_;
};

}  // namespace terray
