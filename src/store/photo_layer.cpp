// SPDX-License-Identifier: Apache-2.0
// Sizes, places and paths of a store's photo.
#include "store/photo_layer.h"

#include <fmt/format.h>

#include <cmath>

namespace terray {
namespace {

int64_t halved(int64_t pixels, int mip) { return (pixels + (int64_t{1} << mip) - 1) >> mip; }

}  // namespace

int PhotoLayer::mipCount() const {
    int mips = 1;
    while (halved(std::max(columns, rows), mips - 1) > kBlockPosts) ++mips;
    return mips;
}

BlockGrid PhotoLayer::grid(int mip) const { return {halved(columns, mip), halved(rows, mip)}; }

Affine2 PhotoLayer::worldFromPixelOf(int mip) const {
    const double scale = std::ldexp(1.0, mip), middle = 0.5 * scale - 0.5;
    return {worldFromPixel.worldFromLattice({middle, middle}), scale * worldFromPixel.column,
            scale * worldFromPixel.row};
}

GeoTransform PhotoLayer::geoTransform(double metresPerCrsUnit, int mip, int64_t column,
                                      int64_t row) const {
    const Affine2 map = worldFromPixelOf(mip);
    const double unit = 1 / metresPerCrsUnit;
    const Vec2 corner = unit * map.worldFromLattice({static_cast<double>(column) - 0.5,
                                                     static_cast<double>(row) - 0.5});
    const Vec2 x = unit * map.column, y = unit * map.row;
    return {{corner.x, x.x, y.x, corner.y, x.y, y.y}};
}

std::string photoShardPath(ShardId shard) {
    return fmt::format("photo/m{}/y{}_x{}.tif", shard.mip, shard.y, shard.x0);
}
std::string photoMipVrtPath(int mip) { return fmt::format("photo/m{}.vrt", mip); }

}  // namespace terray
