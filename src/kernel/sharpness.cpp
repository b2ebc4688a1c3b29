// SPDX-License-Identifier: Apache-2.0
// The sharpness pyramid of a tile slot: how much the slope falls off at a post or within a cell, in
// blocks of 4 x 4 cells and up.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/simd_clones.h"
#include "kernel/pyramid.h"

namespace terray {
namespace {

constexpr int kCells = 512, kPosts = kCells + 1, kSide = 4;
static_assert(kSide == 1 << kSharpestLevel);
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Codes are the exponent and three mantissa bits of a float, from 2^-11 m on: 8 an octave.
constexpr uint32_t kFirstCode = (127 - 11) << 3;

#define TERRAY_INLINE inline __attribute__((always_inline))

/// The kinds of posts: what a difference of theirs is, and what tells a hole.
struct Codes {
    using Post = uint16_t;
    using Sum = int32_t;
    static constexpr Sum kSharp = 0xFFFFF;
    static TERRAY_INLINE uint32_t isHole(Post post) { return post == 0xFFFF ? 1 : 0; }
};
struct Metres {
    using Post = float;
    using Sum = float;
    static constexpr Sum kSharp = kInfinity;
    static TERRAY_INLINE uint32_t isHole(Post post) { return post != post ? 1 : 0; }
};

/// How much the slope falls off at the posts of a row, from before to behind.
template <class Kind, class Post = typename Kind::Post, class Sum = typename Kind::Sum>
TERRAY_INLINE void bend(const Post* before, const Post* at, const Post* behind, int count,
                        Sum* most) {
    for (int i = 0; i < count; ++i) {
        const Sum a = static_cast<Sum>(before[i]), b = static_cast<Sum>(at[i]);
        const Sum c = static_cast<Sum>(behind[i]);
        const uint32_t hole =
            Kind::isHole(before[i]) | Kind::isHole(at[i]) | Kind::isHole(behind[i]);
        const Sum fall = hole != 0 ? Kind::kSharp : (b - a) - (c - b);
        most[i] = most[i] > fall ? most[i] : fall;
    }
}

/// How much the slope along one side of a cell differs from that along the other.
template <class Kind, class Post = typename Kind::Post, class Sum = typename Kind::Sum>
TERRAY_INLINE void twist(const Post* upper, const Post* lower, int cells, Sum* most) {
    for (int i = 0; i < cells; ++i) {
        const Sum top = static_cast<Sum>(upper[i + 1]) - static_cast<Sum>(upper[i]);
        const Sum bottom = static_cast<Sum>(lower[i + 1]) - static_cast<Sum>(lower[i]);
        const uint32_t hole = Kind::isHole(upper[i]) | Kind::isHole(upper[i + 1]) |
                              Kind::isHole(lower[i]) | Kind::isHole(lower[i + 1]);
        const Sum difference = bottom > top ? bottom - top : top - bottom;
        const Sum value = hole != 0 ? Kind::kSharp : difference;
        most[i] = most[i] > value ? most[i] : value;
    }
}

/// Sharpest of the cells of rows [y, y + rows), per column of cells. What is beyond the rim comes
/// from the halo; where nothing is, the ground is taken to go on evenly.
template <class Kind, class Post = typename Kind::Post, class Sum = typename Kind::Sum>
TERRAY_INLINE void measure(const Post* posts, int cellsX, int cellsY, int y, int rows,
                           const TileHalo<Post>& halo, Sum* most) {
    alignas(64) Sum bends[kPosts], twists[kCells];
    std::fill(bends, bends + kPosts, Sum{0});
    std::fill(twists, twists + kCells, Sum{0});
    for (int j = y; j <= y + rows; ++j) {
        const Post* row = posts + static_cast<ptrdiff_t>(j) * kPostStride;
        const Post* above = j > 0 ? row - kPostStride : halo.top;
        const Post* below = j < cellsY ? row + kPostStride : halo.bottom;
        if (above != nullptr && below != nullptr) bend<Kind>(above, row, below, cellsX + 1, bends);
        bend<Kind>(row, row + 1, row + 2, cellsX - 1, bends + 1);
        if (halo.left != nullptr) bend<Kind>(halo.left + j, row, row + 1, 1, bends);
        if (halo.right != nullptr)
            bend<Kind>(row + cellsX - 1, row + cellsX, halo.right + j, 1, bends + cellsX);
        if (j < y + rows) twist<Kind>(row, row + kPostStride, cellsX, twists);
    }
    for (int i = 0; i < cellsX; ++i) {
        const Sum corner = bends[i] > bends[i + 1] ? bends[i] : bends[i + 1];
        most[i] = twists[i] > corner ? twists[i] : corner;
    }
}

TERRAY_SIMD_CLONES
void measureRows(const uint16_t* posts, int cellsX, int cellsY, int y, int rows,
                 const TileHalo<uint16_t>& halo, int32_t* most) {
    measure<Codes>(posts, cellsX, cellsY, y, rows, halo, most);
}
TERRAY_SIMD_CLONES
void measureRows(const float* posts, int cellsX, int cellsY, int y, int rows,
                 const TileHalo<float>& halo, float* most) {
    measure<Metres>(posts, cellsX, cellsY, y, rows, halo, most);
}

void upperLevels(uint8_t* sharpness) {
    for (int level = kSharpestLevel + 1; level <= kTileLevels; ++level) {
        const int size = kCells >> level;
        const uint8_t* fine = sharpness + sharpnessOffset(level - 1);
        uint8_t* out = sharpness + sharpnessOffset(level);
        for (int y = 0; y < size; ++y) {
            const uint8_t* upper = fine + 4 * y * size;
            const uint8_t* lower = upper + 2 * size;
            for (int x = 0; x < size; ++x)
                out[y * size + x] = std::max(std::max(upper[2 * x], upper[2 * x + 1]),
                                             std::max(lower[2 * x], lower[2 * x + 1]));
        }
    }
}

template <class Sum, class Post, class ToMetres>
float build(const Post* posts, int cellsX, int cellsY, const TileHalo<Post>& halo,
            const ToMetres& toMetres, uint8_t* sharpness) {
    alignas(64) Sum most[kCells];
    uint8_t greatest = 0;
    std::fill_n(sharpness, kSlotSharpness, uint8_t{0});
    for (int y = 0; y < cellsY; y += kSide) {
        measureRows(posts, cellsX, cellsY, y, std::min(kSide, cellsY - y), halo, most);
        uint8_t* out = sharpness + y / kSide * (kCells / kSide);
        for (int x = 0; x < cellsX; x += kSide) {
            const Sum* from = most + x;
            const Sum worst = *std::max_element(from, from + std::min(kSide, cellsX - x));
            const uint8_t code = out[x / kSide] = sharpnessCode(toMetres(worst));
            if (code != 255) greatest = std::max(greatest, code);
        }
    }
    upperLevels(sharpness);
    return sharpnessOf(greatest);
}

}  // namespace

uint8_t sharpnessCode(float metres) {
    if (!(metres < kInfinity)) return 255;
    const uint32_t bits = std::bit_cast<uint32_t>(metres) >> 20;
    return bits < kFirstCode ? uint8_t{0}
                             : static_cast<uint8_t>(std::min(bits - kFirstCode + 1, 255u));
}

float sharpnessOf(uint8_t code) {
    if (code == 255) return kInfinity;
    return std::bit_cast<float>((kFirstCode + code) << 20);
}

float buildSharpness(const uint16_t* posts, int cellsX, int cellsY, const TileHalo<uint16_t>& halo,
                     const TileDesc& tile, uint8_t* sharpness) {
    const float step = std::fabs(tile.zStep);
    const float rounding = 0x1p-22f * (std::fabs(tile.z0) + 65535.0f * step);
    const auto toMetres = [=](int32_t codes) {
        return codes >= Codes::kSharp ? kInfinity : step * static_cast<float>(codes) + rounding;
    };
    return build<int32_t>(posts, cellsX, cellsY, halo, toMetres, sharpness);
}

float buildSharpness(const float* posts, int cellsX, int cellsY, const TileHalo<float>& halo,
                     uint8_t* sharpness) {
    const auto toMetres = [](float metres) { return metres * 1.000001f; };
    return build<float>(posts, cellsX, cellsY, halo, toMetres, sharpness);
}

}  // namespace terray
