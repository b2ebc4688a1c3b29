// SPDX-License-Identifier: Apache-2.0
// The slots of a resident terrain: one mapping that holds the posts of all tiles, then their
// pyramids. Pages that nothing is written to cost no memory.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.h"
#include "kernel/pyramid.h"
#include "stream/resident.h"
#include "tile/mips.h"

namespace terray {

/// Kernels gather with signed 32-bit byte offsets from the middle of a pool.
constexpr uint64_t kLargestPoolBytes = uint64_t{4} << 30;

/// Bytes of all posts, and of all pyramids, of a terrain.
struct PoolSizes {
    double slots = 0, postBytes = 0, boundBytes = 0, tableBytes = 0;
    double total() const { return postBytes + boundBytes + tableBytes; }
};
PoolSizes poolSizes(const TerrainInfo& info);

/// Slots of all tiles: those of mip 0 row by row, then those of mip 1, and so on.
struct ResidentTerrain::Pool {
    static Result<std::unique_ptr<Pool>> make(const TerrainInfo& info);
    ~Pool();
    Pool(const Pool&) = delete;
    Pool& operator=(const Pool&) = delete;

    TilingScheme scheme;
    Affine2 worldFromLattice;
    PostFormat format = PostFormat::Float32;
    int mips = 0;
    std::vector<uint32_t> firstSlot;     ///< per mip
    std::vector<TileDesc> tiles;         ///< per slot
    std::vector<TileId> ids;             ///< per slot
    std::vector<SlotBounds> slotBounds;  ///< per slot
    std::vector<BlockBounds> blocks;     ///< 64 per slot
    std::vector<uint8_t> sharpness;      ///< kSlotSharpness per slot
    void* posts = nullptr;               ///< uint16_t or float
    uint32_t* bounds = nullptr;

    uint32_t slotOf(TileId id) const;
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
    Result<void> map();
    void layOut();
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
