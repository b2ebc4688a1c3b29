// SPDX-License-Identifier: Apache-2.0
// Pyramid and sharpness of one slot, with the posts of its neighbours beyond its rim.
#include "stream/slot.h"

#include <limits>
#include <type_traits>

namespace terray {
namespace {

/// Borders are shared: the posts beyond a tile's rim are the second ones of its neighbours.
template <class Post>
struct HaloPosts {
    std::vector<Post> left, right, top, bottom;
    TileHalo<Post> halo() const {
        const auto at = [](const std::vector<Post>& posts) {
            return posts.empty() ? nullptr : posts.data();
        };
        return {at(left), at(right), at(top), at(bottom)};
    }
};

template <class Post>
Post holePost() {
    if constexpr (std::is_same_v<Post, uint16_t>)
        return kHolePost;
    else
        return std::numeric_limits<Post>::quiet_NaN();
}

template <class Post>
HaloPosts<Post> haloOf(const ResidentTerrain::Pool& pool, TileId id) {
    HaloPosts<Post> halo;
    const auto take = [&](int dx, int dy, int column, int row, ptrdiff_t step, int count,
                          std::vector<Post>& out) {
        const uint32_t number = pool.numberOf({id.mip, id.x + dx, id.y + dy});
        if (number == kNoSlot) return;
        if (pool.isHollow(number)) out.assign(static_cast<size_t>(count), holePost<Post>());
        const uint32_t slot = pool.slots[number];
        if (slot == kNoSlot) return;
        const Post* from = pool.postsOf<Post>(slot) + ptrdiff_t{row} * kPostStride + column;
        for (int k = 0; k < count; ++k) out.push_back(from[k * step]);
    };
    const int width = pool.cellsX(id) + 1, height = pool.cellsY(id) + 1;
    take(-1, 0, kTileCells - 1, 0, kPostStride, height, halo.left);
    take(1, 0, 1, 0, kPostStride, height, halo.right);
    take(0, -1, 0, kTileCells - 1, 1, width, halo.top);
    take(0, 1, 0, 1, 1, width, halo.bottom);
    return halo;
}

}  // namespace

void makePyramid(ResidentTerrain::Pool& pool, uint32_t slot) {
    const TileId id = pool.ids[slot];
    TileDesc& tile = pool.tiles[slot];
    uint32_t* bounds = pool.bounds + tile.bounds;
    const int cellsX = pool.cellsX(id), cellsY = pool.cellsY(id);
    pool.slotBounds[slot] =
        pool.format == PostFormat::Int16
            ? buildPyramid(pool.postsOf<const uint16_t>(slot), cellsX, cellsY, tile, bounds)
            : buildPyramid(pool.postsOf<const float>(slot), cellsX, cellsY, tile, bounds);
}

void makeSharpness(ResidentTerrain::Pool& pool, uint32_t slot) {
    const TileId id = pool.ids[slot];
    const int cellsX = pool.cellsX(id), cellsY = pool.cellsY(id);
    uint8_t* out = pool.sharpness.data() + size_t{slot} * kSlotSharpness;
    float& sharpest = pool.slotBounds[slot].sharpest;
    if (pool.format == PostFormat::Int16) {
        const auto halo = haloOf<uint16_t>(pool, id);
        sharpest = buildSharpness(pool.postsOf<const uint16_t>(slot), cellsX, cellsY, halo.halo(),
                                  pool.tiles[slot], out);
    } else {
        const auto halo = haloOf<float>(pool, id);
        sharpest =
            buildSharpness(pool.postsOf<const float>(slot), cellsX, cellsY, halo.halo(), out);
    }
}

}  // namespace terray
