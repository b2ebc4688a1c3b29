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
    PoolSizes sizes;
    const int mips = info.scheme.mipCount();
    for (int mip = 0; mip < mips; ++mip) {
        sizes.slots += static_cast<double>(info.scheme.tilesX(mip)) * info.scheme.tilesY(mip);
    }
    const double perSlot = sizeof(TileDesc) + sizeof(TileId) + sizeof(SlotBounds) +
                           kTileBlocks * kTileBlocks * sizeof(BlockBounds) + kSlotSharpness;
    sizes.postBytes = sizes.slots * kSlotPosts * static_cast<double>(postSize(info.format));
    sizes.boundBytes = sizes.slots * kSlotBounds * sizeof(uint32_t);
    sizes.tableBytes = sizes.slots * perSlot;
    return sizes;
}

Result<std::unique_ptr<ResidentTerrain::Pool>> ResidentTerrain::Pool::make(
    const TerrainInfo& info) {
    std::unique_ptr<Pool> pool(new Pool);
    pool->scheme = info.scheme;
    pool->worldFromLattice = info.worldFromLattice;
    pool->format = info.format;
    pool->mips = info.scheme.mipCount();
    pool->layOut();
    for (TileDesc& tile : pool->tiles) {
        tile.z0 = info.z0;
        tile.zStep = info.zStep;
    }
    TERRAY_TRY(pool->map());
    return pool;
}

ResidentTerrain::Pool::~Pool() {
    if (mapping_ != nullptr) munmap(mapping_, mappingBytes_);
}

void ResidentTerrain::Pool::layOut() {
    uint32_t slot = 0;
    for (int mip = 0; mip < mips; ++mip) {
        firstSlot.push_back(slot);
        for (int y = 0; y < scheme.tilesY(mip); ++y) {
            for (int x = 0; x < scheme.tilesX(mip); ++x, ++slot) {
                TileDesc tile{};
                tile.posts = uint64_t{slot} * kSlotPosts;
                tile.bounds = uint64_t{slot} * kSlotBounds;
                tile.x = (x * kTileCells) << mip;
                tile.y = (y * kTileCells) << mip;
                tile.mipFlags = static_cast<uint32_t>(mip);
                tiles.push_back(tile);
                ids.push_back(TileId{mip, x, y});
            }
        }
    }
    for (uint32_t s = 0; s < slot; ++s) {
        const TileId id = ids[s];
        tiles[s].parent = slotOf(TileId{id.mip + 1, id.x / 2, id.y / 2});
    }
    slotBounds.resize(slot);
    blocks.resize(size_t{slot} * kTileBlocks * kTileBlocks);
    sharpness.resize(size_t{slot} * kSlotSharpness);
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

uint32_t ResidentTerrain::Pool::slotOf(TileId id) const {
    if (id.mip < 0 || id.mip >= mips || id.x < 0 || id.y < 0) return kNoSlot;
    const int columns = scheme.tilesX(id.mip);
    if (id.x >= columns || id.y >= scheme.tilesY(id.mip)) return kNoSlot;
    return firstSlot[static_cast<size_t>(id.mip)] +
           static_cast<uint32_t>(id.y) * static_cast<uint32_t>(columns) +
           static_cast<uint32_t>(id.x);
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
