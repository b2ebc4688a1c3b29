// SPDX-License-Identifier: Apache-2.0
// Mapping, slot arithmetic and decoding of a resident terrain's pool.
#include "stream/pool.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>

#include "base/assert.h"
#include "tile/codes.h"

namespace terray {
namespace {

constexpr size_t kHugePage = size_t{2} << 20;

size_t postSize(PostFormat format) {
    return format == PostFormat::Int16 ? sizeof(uint16_t) : sizeof(float);
}

}  // namespace

PoolSizes poolSizes(const TerrainInfo& info) {
    double tiles = 0;
    for (int mip = 0; mip < info.scheme.mipCount(); ++mip) {
        tiles += static_cast<double>(info.scheme.tilesX(mip)) * info.scheme.tilesY(mip);
    }
    return poolSizes(info, tiles);
}

PoolSizes poolSizes(const TerrainInfo& info, double slots) {
    PoolSizes sizes;
    double tiles = 0;
    for (int mip = 0; mip < info.scheme.mipCount(); ++mip) {
        tiles += static_cast<double>(info.scheme.tilesX(mip)) * info.scheme.tilesY(mip);
    }
    const double perTile = sizeof(uint32_t) + kBlocksPerTile * sizeof(BlockBounds);
    const double perSlot = sizeof(TileDesc) + sizeof(TileId) + sizeof(SlotBounds) + kSlotSharpness;
    sizes.slots = slots;
    sizes.postBytes = slots * kSlotPosts * static_cast<double>(postSize(info.format));
    sizes.boundBytes = slots * kSlotBounds * sizeof(uint32_t);
    sizes.tableBytes = slots * perSlot + tiles * perTile;
    return sizes;
}

std::unique_ptr<ResidentTerrain::Pool> ResidentTerrain::Pool::makeTable(const TerrainInfo& info) {
    std::unique_ptr<Pool> pool(new Pool);
    pool->scheme = info.scheme;
    pool->worldFromLattice = info.worldFromLattice;
    pool->format = info.format;
    pool->mips = info.scheme.mipCount();
    uint32_t tiles = 0;
    for (int mip = 0; mip < pool->mips; ++mip) {
        pool->firstTile.push_back(tiles);
        tiles += static_cast<uint32_t>(info.scheme.tileCount(mip));
    }
    pool->slots.assign(tiles, kNoSlot);
    pool->blocks.resize(tiles * kBlocksPerTile);
    pool->z0_ = info.z0;
    pool->zStep_ = info.zStep;
    return pool;
}

Result<std::unique_ptr<ResidentTerrain::Pool>> ResidentTerrain::Pool::make(
    const TerrainInfo& info) {
    std::unique_ptr<Pool> pool = makeTable(info);
    const auto count = static_cast<uint32_t>(pool->slots.size());
    pool->addSlots(count);
    for (uint32_t slot = 0; slot < count; ++slot) {
        pool->slots[slot] = slot;
        pool->assign(slot, pool->tileOf(slot));
    }
    TERRAY_TRY(pool->map());
    return pool;
}

Result<std::unique_ptr<ResidentTerrain::Pool>> ResidentTerrain::Pool::makeFree(
    const TerrainInfo& info, uint32_t slots) {
    std::unique_ptr<Pool> pool = makeTable(info);
    pool->addSlots(slots);
    TERRAY_TRY(pool->map());
    return pool;
}

ResidentTerrain::Pool::~Pool() {
    if (mapping_ != nullptr) munmap(mapping_, mappingBytes_);
}

void ResidentTerrain::Pool::addSlots(uint32_t count) {
    tiles.resize(count);
    ids.assign(count, TileId{-1, 0, 0});
    slotBounds.resize(count);
    sharpness.resize(size_t{count} * kSlotSharpness);
    for (uint32_t slot = 0; slot < count; ++slot) {
        tiles[slot].posts = uint64_t{slot} * kSlotPosts;
        tiles[slot].bounds = uint64_t{slot} * kSlotBounds;
    }
}

void ResidentTerrain::Pool::takeBlocks(const TileSource& source) {
    hollow.resize(slots.size());
    for (uint32_t number = 0; number < slots.size(); ++number) {
        const TileId id = tileOf(number);
        bool any = false;
        for (int k = 0; k < int{kBlocksPerTile}; ++k) {
            const int x = k % kTileBlocks, y = k / kTileBlocks;
            const BlockBounds& block = source.block(id, x, y);
            blocks[number * kBlocksPerTile + static_cast<size_t>(k)] = block;
            const bool isInside = x * kBlockCells < cellsX(id) && y * kBlockCells < cellsY(id);
            any = any || (isInside && block.minZ <= block.maxZ);
        }
        hollow[number] = any ? 0 : 1;
    }
}

void ResidentTerrain::Pool::assign(uint32_t slot, TileId id) {
    TileDesc& tile = tiles[slot];
    tile.x = (id.x * kTileCells) << id.mip;
    tile.y = (id.y * kTileCells) << id.mip;
    tile.mipFlags = static_cast<uint32_t>(id.mip);
    tile.z0 = z0_;
    tile.zStep = zStep_;
    ids[slot] = id;
}

/// One mapping, begun on a huge page; its end is not rounded up, so nothing is wasted there.
Result<void> ResidentTerrain::Pool::map() {
    const size_t postBytes = tiles.size() * kSlotPosts * postSize(format);
    const size_t postsEnd = (postBytes + 63) / 64 * 64;
    const size_t bytes = postsEnd + tiles.size() * kSlotBounds * sizeof(uint32_t);
    mappingBytes_ = bytes + kHugePage;
    void* mapping = mmap(nullptr, mappingBytes_, PROT_READ | PROT_WRITE,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapping == MAP_FAILED) {
        return makeError(ErrorCode::Resource,
                         "the system refuses {:.2f} GiB of memory for the terrain; free some or "
                         "take a smaller window of the data",
                         static_cast<double>(bytes) / (1 << 30));
    }
    mapping_ = mapping;
    const auto address = reinterpret_cast<uintptr_t>(mapping);
    const uintptr_t start = (address + kHugePage - 1) / kHugePage * kHugePage;
    std::byte* base = static_cast<std::byte*>(mapping) + (start - address);
    madvise(base, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
    posts = base;
    bounds = reinterpret_cast<uint32_t*>(base + postsEnd);
    return {};
}

uint32_t ResidentTerrain::Pool::numberOf(TileId id) const {
    if (id.mip < 0 || id.mip >= mips || id.x < 0 || id.y < 0) return kNoSlot;
    const int columns = scheme.tilesX(id.mip);
    if (id.x >= columns || id.y >= scheme.tilesY(id.mip)) return kNoSlot;
    return firstTile[static_cast<size_t>(id.mip)] +
           static_cast<uint32_t>(id.y) * static_cast<uint32_t>(columns) +
           static_cast<uint32_t>(id.x);
}

TileId ResidentTerrain::Pool::tileOf(uint32_t number) const {
    int mip = mips - 1;
    while (firstTile[static_cast<size_t>(mip)] > number) --mip;
    const uint32_t inMip = number - firstTile[static_cast<size_t>(mip)];
    const auto columns = static_cast<uint32_t>(scheme.tilesX(mip));
    return {mip, static_cast<int>(inMip % columns), static_cast<int>(inMip / columns)};
}

uint32_t ResidentTerrain::Pool::slotOf(TileId id) const {
    const uint32_t number = numberOf(id);
    return number == kNoSlot ? kNoSlot : slots[number];
}

int ResidentTerrain::Pool::cellsX(TileId id) const { return scheme.cellsX(id); }
int ResidentTerrain::Pool::cellsY(TileId id) const { return scheme.cellsY(id); }

void ResidentTerrain::Pool::decodeRow(uint32_t slot, int row, int column, int count,
                                      float* out) const {
    const ptrdiff_t offset = static_cast<ptrdiff_t>(row) * kPostStride + column;
    if (format == PostFormat::Float32) {
        const float* from = postsOf<float>(slot) + offset;
        std::copy(from, from + count, out);
    } else {
        decodeCodes(postsOf<uint16_t>(slot) + offset, count, tiles[slot].z0, tiles[slot].zStep,
                    out);
    }
}

void ResidentTerrain::Pool::encodeRow(uint32_t slot, int row, const float* heights,
                                      int count) const {
    const ptrdiff_t offset = static_cast<ptrdiff_t>(row) * kPostStride;
    if (format == PostFormat::Float32) {
        std::copy(heights, heights + count, postsOf<float>(slot) + offset);
    } else {
        encodeHeights(heights, count, tiles[slot].z0, tiles[slot].zStep,
                      postsOf<uint16_t>(slot) + offset);
    }
}

void MipRows::read(int64_t row, int64_t column, int64_t count, float* out) const {
    TERRAY_ASSERT(row >= 0 && row < rows() && column >= 0 && column + count <= columns());
    const int tilesX = pool_.scheme.tilesX(mip_), tilesY = pool_.scheme.tilesY(mip_);
    const int y = std::min(static_cast<int>(row >> kTileCellsLog2), tilesY - 1);
    const int localRow = static_cast<int>(row - int64_t{y} * kTileCells);
    while (count > 0) {
        const int x = std::min(static_cast<int>(column >> kTileCellsLog2), tilesX - 1);
        const int localColumn = static_cast<int>(column - int64_t{x} * kTileCells);
        const int part = static_cast<int>(std::min<int64_t>(count, kTilePosts - localColumn));
        pool_.decodeRow(pool_.slotOf(TileId{mip_, x, y}), localRow, localColumn, part, out);
        column += part;
        count -= part;
        out += part;
    }
}

}  // namespace terray
