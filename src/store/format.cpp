// SPDX-License-Identifier: Apache-2.0
// Paths and geotransforms of the store's parts.
#include "store/format.h"

#include <fmt/format.h>

#include <cmath>

namespace terray {

std::string shardPath(ShardId shard) {
    return fmt::format("height/m{}/y{}_x{}.tif", shard.mip, shard.y, shard.x0);
}
std::string edgesPath(int mip) { return fmt::format("edges/m{}.bin", mip); }
std::string boundsPath(int mip) { return fmt::format("bounds/m{}.tif", mip); }
std::string mipVrtPath(int mip) { return fmt::format("height/m{}.vrt", mip); }

GeoTransform geoTransformOf(const TerrainInfo& info, int mip, int64_t column, int64_t row) {
    const double scale = std::ldexp(1.0, mip), unit = 1 / info.metresPerCrsUnit;
    const Affine2& map = info.worldFromLattice;
    const Vec2 pixelX = unit * scale * map.column, pixelY = unit * scale * map.row;
    const Vec2 post = unit * map.worldFromLattice({scale * static_cast<double>(column),
                                                   scale * static_cast<double>(row)});
    const Vec2 corner = post - 0.5 * pixelX - 0.5 * pixelY;
    return {{corner.x, pixelX.x, pixelY.x, corner.y, pixelX.y, pixelY.y}};
}

}  // namespace terray
