// SPDX-License-Identifier: Apache-2.0
// The plane affine map between the post lattice and the world: rotated, sheared, south-up and
// non-square rasters are all handled here, once, so that kernels see unit cells.
#pragma once

#include "math/types.h"

namespace terray {

/// world = origin + i * column + j * row. Regular: det() != 0.
struct Affine2 {
    Vec2 origin{0, 0};  ///< world place of post (0, 0), metres
    Vec2 column{1, 0};  ///< step to the next post in a row, metres
    Vec2 row{0, -1};    ///< step to the next row, metres

    double det() const { return column.x * row.y - column.y * row.x; }
    Vec2 worldFromLattice(LatticePoint p) const { return origin + p.i * column + p.j * row; }
    LatticePoint latticeFromWorld(Vec2 w) const { return latticeDirection(w - origin); }
    /// Lattice components of a world direction (no translation).
    LatticePoint latticeDirection(Vec2 d) const {
        const double s = 1.0 / det();
        return {(d.x * row.y - d.y * row.x) * s, (d.y * column.x - d.x * column.y) * s};
    }
    /// World gradient (dz/dx, dz/dy) from the gradient per lattice step (dz/di, dz/dj).
    Vec2 worldGradient(double dzdi, double dzdj) const {
        const double s = 1.0 / det();
        return {(dzdi * row.y - dzdj * column.y) * s, (dzdj * column.x - dzdi * row.x) * s};
    }
    double columnLength() const { return glm::length(column); }
    double rowLength() const { return glm::length(row); }
};

}  // namespace terray
