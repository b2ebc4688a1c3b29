// SPDX-License-Identifier: Apache-2.0
// Chooses between marching a tile's rows upwards or downwards and its columns sideways.
#include "technique/ray_cast/march_view.h"

#include <cmath>

#include "technique/ray_cast/neighbours.h"

namespace terray {
namespace {

double aheadAt(const RayFrame& rays, double px, double py) {
    return std::fabs(rays.columnTerms(px)[kTermForward] + rays.rowTerms(py)[kTermForward]);
}

}  // namespace

MarchView viewFor(const RayFrame& rays, const ImageTile& tile, Vec2 offset) {
    const MarchView straight{rays, tile, offset, false};
    if (rays.camera().projection == Projection::Panorama) return straight;
    const double x = tile.x + 0.5 * tile.width, y = tile.y + 0.5 * tile.height;
    const double aside = asideAt(rays, x, y);
    if (aside < 0.5) return straight;
    MarchView turned{
        rays.turned(), {tile.y, tile.x, tile.height, tile.width}, {offset.y, offset.x}, true};
    const RayFrame sideways = turned.rays.lookingAside();
    if (aheadAt(sideways, y, x) > aheadAt(turned.rays, y, x)) turned.rays = sideways;
    return asideAt(turned.rays, y, x) < 0.8 * aside ? turned : straight;
}

}  // namespace terray
