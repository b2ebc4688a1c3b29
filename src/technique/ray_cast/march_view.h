// SPDX-License-Identifier: Apache-2.0
// An image tile as the march sees it: rows that follow each other outwards from the nadir, which
// may be the picture's columns.
#pragma once

#include <cstddef>

#include "view/ray_frame.h"

namespace terray {

struct MarchView {
    RayFrame rays;        ///< whose columns are the lanes
    ImageTile tile;       ///< in its pixels
    Vec2 offset;          ///< sample place in a pixel
    bool turned = false;  ///< rows and columns of the picture are exchanged

    double px(int column) const { return tile.x + column + offset.x; }
    double py(int row) const { return tile.y + row + offset.y; }
    /// Index of a hit, of which the picture's rows are `stride` apart.
    size_t indexOf(int row, int column, size_t stride) const {
        const auto r = static_cast<size_t>(row), c = static_cast<size_t>(column);
        return turned ? c * stride + r : r * stride + c;
    }
};

/// The way to march in which a ray stands least aside of those of the row below.
MarchView viewFor(const RayFrame& rays, const ImageTile& tile, Vec2 offset);

}  // namespace terray
