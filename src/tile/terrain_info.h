// SPDX-License-Identifier: Apache-2.0
// What is known of a terrain before any height is read: plain numbers and WKT text, no library
// types.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "math/affine.h"
#include "tile/tile_id.h"

namespace terray {

/// How a tile's posts are kept. Int16: z = z0 + zStep * q with q in 0..65534 and kHolePost for
/// holes.
enum class PostFormat : uint32_t { Int16 = 0, Float32 = 1 };
constexpr uint16_t kHolePost = 0xFFFF;

struct TerrainInfo {
    std::string name;          ///< as the user wrote it
    TilingScheme scheme;       ///< posts of mip 0
    Affine2 worldFromLattice;  ///< metres in the working CRS
    std::string crsWkt;        ///< working CRS (WKT2), empty if none is known
    double metresPerCrsUnit =
        1;  ///< working CRS's linear unit; world coordinates are CRS coordinates times this
    double ellipsoidRadius = 0;  ///< metres; radius of curvature at the centre, 0 = flat (no CRS)
    PostFormat format = PostFormat::Float32;
    float z0 = 0, zStep = 0;  ///< decoding of Int16 posts, the same for every tile and mip
    float minZ = 0,
          maxZ = 0;  ///< metres, over the valid posts of mip 0; exact once the terrain is resident
};

/// Bounds of 64 x 64 cells of a tile, row-major, 8 x 8 a tile; heights in metres, rounded outwards.
struct BlockBounds {
    float minZ = 0, maxZ = 0;  ///< of the block's cells; minZ > maxZ: all hole
    float errorToFinest = 0;   ///< largest |S_m - S_0| over the block
    float errorToNext = 0;     ///< largest |S_m - S_(m+1)| over the block
    float maxSlope = 0;        ///< largest world slope (rise over run)
    float cellRange = 0;       ///< largest height range of one of its cells, mip 0's included
    float coverageError = 0;   ///< metres on the ground by which rims of holes may stand elsewhere
                               ///< than at mip 0: a cell's diagonal, 0 where coverage is the same
    uint32_t flags = 0;        ///< kBlockHasHoles, kBlockFinestHasHoles, kBlockFinestHasCells
};
constexpr uint32_t kBlockHasHoles = 1;        ///< a cell of the block is a hole
constexpr uint32_t kBlockFinestHasHoles = 2;  ///< a cell of mip 0 in it is a hole
constexpr uint32_t kBlockFinestHasCells = 4;  ///< a cell of mip 0 in it is none

}  // namespace terray
