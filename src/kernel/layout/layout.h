// SPDX-License-Identifier: Apache-2.0
// The tracer's whole world: the structs that CPU kernels, and later shaders, read. docs/surface.md.
#pragma once

#include <cstddef>
#include <cstdint>

namespace terray {

// ---- A tile slot: 513 x 513 posts, and a pyramid of (min, max) over its cells
// ------------------------

constexpr int kSlotCells = 512;  ///< cells a side of a tile
constexpr int kPostStride =
    520;  ///< posts a row in a slot (513 used): rows do not alias in the cache
constexpr int kSlotPosts = kPostStride * 513;

/// Pyramid levels inside a tile: blocks of 2^l x 2^l cells, l = 1 (256 x 256 entries) ... 9 (one
/// entry). One entry is (max << 16 | min) in 16-bit codes: z = boundsZ0 + boundsStep * code,
/// rounded outwards; min > max means that every cell of the block is a hole.
constexpr int kTileLevels = 9;
constexpr uint32_t levelOffset(int level) {
    uint32_t offset = 0;
    for (int l = 1; l < level; ++l) offset += (512u >> l) * (512u >> l);
    return offset;
}
constexpr uint32_t kSlotBounds = levelOffset(kTileLevels + 1);
constexpr uint32_t kEmptyBounds = 0x0000FFFFu;  ///< max 0, min 65535
static_assert(kSlotBounds == 87381);

/// Sharpness pyramid of a tile: for blocks of 4 x 4 cells (level 2) and larger ones, one byte: by
/// how many metres a cell the slope falls off at most at a post of its cells, along a row or a
/// column, or within a cell, either way; rounded up (kernel/pyramid.h).
constexpr int kSharpestLevel = 2;
constexpr uint32_t sharpnessOffset(int level) {
    return levelOffset(level) - levelOffset(kSharpestLevel);
}
constexpr uint32_t kSlotSharpness = sharpnessOffset(kTileLevels + 1);
static_assert(kSlotSharpness == 21845);

constexpr uint32_t kTileMipMask = 0xFFu;

/// One resident tile. posts and bounds count elements from the start of their pools; multiply by
/// the element size (2 or 4 bytes for posts, 4 for bounds).
struct TileDesc {
    uint64_t posts, bounds;
    int32_t x, y;     ///< first post, in mip-0 cells of the lattice
    float z0, zStep;  ///< Int16 posts: z = z0 + zStep * code
    float boundsZ0, boundsStep;
    float maxDelta;     ///< largest |height difference| of neighbouring posts, metres
    uint32_t mipFlags;  ///< low byte: mip
    uint32_t reserved[2];
};
static_assert(sizeof(TileDesc) == 56 && offsetof(TileDesc, z0) == 24 &&
              offsetof(TileDesc, mipFlags) == 44);

constexpr uint32_t kNoSlot = 0xFFFFFFFFu;

// ---- The directory: for every mip d a grid of squares of 512 * 2^d cells
// --------------------------

/// What a ray finds at a square. The tile of mip d at a place has exactly the square of level d, so
/// the directory is page table (slot) and cut (state) at once.
enum SquareState : uint32_t {
    kSquareEmpty = 0,    ///< outside, or all hole: nothing to hit
    kSquareDrawn = 1,    ///< the frame draws the tile in `slot`
    kSquareDescend = 2,  ///< finer tiles are drawn inside
    kSquareCovered = 3,  ///< a coarser tile is drawn here: look further up
};

struct Square {
    float minZ, maxZ;  ///< of everything drawn inside, rounded outwards; undefined when covered
    uint32_t slot;     ///< resident tile of this mip here, kNoSlot if none
    uint32_t state;    ///< SquareState
};
static_assert(sizeof(Square) == 16);

constexpr int kMaxLevels = 24;

struct DirectoryLevel {
    uint32_t offset;  ///< of its first square in the square array
    uint32_t columns, rows;
};

/// What lies between the posts of a cell.
enum SurfaceKind : uint32_t {
    kSurfaceBilinear = 0,
    kSurfaceConstant = 1,   ///< the height of the nearest post, with walls
    kSurfaceTriangles = 2,  ///< two planes, split from post (1, 0) to post (0, 1); for comparisons
};

/// All a kernel needs to trace a frame. Pointers are borrowed from the pool (stream/) for the
/// frame.
struct TerrainCut {
    const TileDesc* tiles = nullptr;
    const void* posts = nullptr;  ///< uint16_t or float, by format
    const uint32_t* bounds = nullptr;
    const uint8_t* sharpness = nullptr;  ///< kSlotSharpness a slot; null: anything may be sharp
    const Square* squares = nullptr;
    DirectoryLevel levels[kMaxLevels] = {};
    int32_t rootLevel = 0;  ///< the directory's coarsest level: one square
    uint32_t format = 0;    ///< PostFormat
    SurfaceKind surface = kSurfaceBilinear;
    uint32_t tileCount = 0;
    int32_t cellsX = 0, cellsY = 0;  ///< true size of mip 0 in cells; rays are clipped to it
    float minZ = 0, maxZ = 0;        ///< of everything drawn, rounded outwards
    float maxDelta = 0;   ///< largest |height difference| of neighbouring posts of drawn tiles
    float codeReach = 0;  ///< largest |z0 - middle of minZ, maxZ| of drawn tiles' height codes
    float maxError = 0;   ///< largest |drawn surface - mip 0| of drawn tiles, metres
    float maxSharpness = 1e30f;  ///< of drawn tiles but beside holes, metres a cell of mip 0
    uint32_t hasHoles = 1;       ///< 0: no drawn cell is a hole
    uint32_t unlikeMips = 1;     ///< 0: all drawn tiles are of one mip
};

// ---- Rays and hits
// ----------------------------------------------------------------------------------

/// A ray in lattice space: x, y in mip-0 cells (post (i, j) at exactly (i, j)), z in true metres.
/// Position at t: x + dx t, y + dy t, z + dz t + bend t^2. With a unit direction in the world, t is
/// the distance in metres. bend >= 0 (earth curvature less refraction, times the squared horizontal
/// length of the direction). Finite, direction not zero; tMax >= 0 may be infinite.
struct Ray {
    double x = 0, y = 0, z = 0;
    double dx = 0, dy = 0, dz = 0;
    double bend = 0;
    double tMin = 0, tMax = 1e30;
};

enum HitFlags : uint8_t {
    kHitValid = 1,      ///< there is a hit; all else is undefined without it
    kHitFromBelow = 2,  ///< the ray came from under the sheet
    kHitStrip =
        4,  ///< on the vertical strip between tiles of unlike mips, or a wall of constant cells
};

/// First hit of a ray. Position: lattice (tile.x + (cellX + u) * 2^mip, ...), exact; height and
/// normal are derived from the tile's posts.
struct Hit {
    float t;         ///< distance along the ray
    uint32_t tile;   ///< slot
    uint32_t cell;   ///< cellY * 512 + cellX in the tile
    float u, v;      ///< place in the cell, 0..1
    uint16_t steps;  ///< traversal steps taken
    uint8_t mip;
    uint8_t flags;  ///< HitFlags
};
static_assert(sizeof(Hit) == 24 && offsetof(Hit, steps) == 20);

inline bool isHit(const Hit& hit) { return (hit.flags & kHitValid) != 0; }
inline uint32_t cellX(const Hit& hit) { return hit.cell & 511u; }
inline uint32_t cellY(const Hit& hit) { return hit.cell >> 9; }

}  // namespace terray
