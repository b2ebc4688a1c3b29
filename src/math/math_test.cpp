// SPDX-License-Identifier: Apache-2.0
// Tests of the lattice-to-world map.
#include <gtest/gtest.h>

#include "math/affine.h"

namespace terray {
namespace {

TEST(Affine2, InverseUndoesRotationAndShear) {
    const Affine2 map{{500000.25, 4e6}, {9.5, 2.5}, {1.0, -11.0}};
    const LatticePoint p = map.latticeFromWorld(map.worldFromLattice({123.75, 456.5}));
    EXPECT_NEAR(p.i, 123.75, 1e-9);
    EXPECT_NEAR(p.j, 456.5, 1e-9);
}

TEST(Affine2, GradientOfAPlaneIsThePlanes) {
    const Affine2 map{{10, 20}, {9.5, 2.5}, {1.0, -11.0}};
    const Vec2 slope{0.3, -0.7};
    const double dzdi = glm::dot(slope, map.column);
    const double dzdj = glm::dot(slope, map.row);
    const Vec2 found = map.worldGradient(dzdi, dzdj);
    EXPECT_NEAR(found.x, slope.x, 1e-12);
    EXPECT_NEAR(found.y, slope.y, 1e-12);
}

}  // namespace
}  // namespace terray
