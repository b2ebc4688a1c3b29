// SPDX-License-Identifier: Apache-2.0
// Tests of heights at places: the drawn cell, its height, hits.
#include "kernel/height.h"

#include <gtest/gtest.h>

#include "kernel/test_cuts.h"

namespace terray {
namespace {

using test::CutChoice;
using test::Heights;
using test::TestCut;

Heights plane(int columns, int rows) {
    return {columns, rows, [](int i, int j) { return 2.0 * i - 3.0 * j + 7; }};
}

TEST(SurfaceCell, PlaneIsReproducedInEveryMip) {
    CutChoice choice;
    choice.mipOfTile = [](int x, int) { return x >= 2 ? 1 : 0; };
    const TestCut terrain(plane(2049, 1025), choice);
    bool sawCoarse = false;
    for (double j = 0.3; j < 1024; j += 97.7) {
        for (double i = 0.1; i < 2048; i += 41.3) {
            const SurfaceCell cell = surfaceCellAt(terrain.cut(), i, j);
            ASSERT_NE(cell.slot, kNoSlot);
            EXPECT_EQ(cell.mip, i >= 1024 ? 1 : 0);
            sawCoarse = sawCoarse || cell.mip == 1;
            // The full-weighting mean of a repeated edge is off the plane.
            if (i > 2 && j > 2 && i < 2046 && j < 1022) {
                EXPECT_NEAR(cell.height(kSurfaceBilinear), 2 * i - 3 * j + 7, 1e-3);
            }
        }
    }
    EXPECT_TRUE(sawCoarse);
}

TEST(SurfaceCell, TrianglesAreTwoPlanes) {
    const test::TestCut terrain(
        test::Heights(2, 2, [](int i, int j) { return i == 1 && j == 1 ? 8 : 0; }));
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 0.25, 0.5).height(kSurfaceTriangles), 0);
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 0.75, 0.5).height(kSurfaceTriangles), 2);
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 1, 1).height(kSurfaceTriangles), 8);
}

TEST(SurfaceCell, ConstantSurfaceTakesTheNearestPost) {
    const TestCut terrain(plane(5, 5));
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 1.4, 2.4).height(kSurfaceConstant),
              2.0 * 1 - 3.0 * 2 + 7);
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 1.6, 2.4).height(kSurfaceConstant),
              2.0 * 2 - 3.0 * 2 + 7);
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 1.4, 2.6).height(kSurfaceConstant),
              2.0 * 1 - 3.0 * 3 + 7);
    EXPECT_EQ(surfaceCellAt(terrain.cut(), 1.6, 2.6).height(kSurfaceConstant),
              2.0 * 2 - 3.0 * 3 + 7);
}

TEST(SurfaceCell, BordersBelongToTheTerrainAndNothingBeyondThem) {
    const TestCut terrain(plane(5, 4));
    EXPECT_NEAR(surfaceCellAt(terrain.cut(), 0, 0).height(kSurfaceBilinear), 7, 1e-6);
    EXPECT_NEAR(surfaceCellAt(terrain.cut(), 4, 3).height(kSurfaceBilinear), 2 * 4 - 3 * 3 + 7,
                1e-6);
    for (const auto& [i, j] : {std::pair{-0.001, 1.0}, {4.001, 1.0}, {1.0, -0.1}, {1.0, 3.5}}) {
        EXPECT_EQ(surfaceCellAt(terrain.cut(), i, j).slot, kNoSlot);
    }
    EXPECT_EQ(surfaceCellAt(terrain.cut(), std::nan(""), 1).slot, kNoSlot);
}

TEST(SurfaceCell, CellsWithAnInvalidCornerAreHoles) {
    Heights heights = plane(6, 6);
    heights.at(2, 3) = std::numeric_limits<float>::quiet_NaN();
    for (const bool int16 : {false, true}) {
        CutChoice choice;
        choice.int16 = int16;
        const TestCut terrain(heights, choice);
        for (int y = 0; y < 5; ++y) {
            for (int x = 0; x < 5; ++x) {
                const bool hole = (x == 1 || x == 2) && (y == 2 || y == 3);
                const SurfaceCell cell = surfaceCellAt(terrain.cut(), x + 0.5, y + 0.5);
                EXPECT_EQ(cell.slot == kNoSlot, hole) << x << ' ' << y;
            }
        }
    }
}

TEST(HitHeight, IsTheSurfaceAtTheHit) {
    const TestCut terrain(plane(700, 40));
    Hit hit{};
    hit.flags = kHitValid;
    hit.tile = terrain.slotOf(0, 1, 0);
    hit.cell = 20 * 512 + 100;
    hit.u = 0.25f;
    hit.v = 0.75f;
    const LatticePlace place = hitPlace(terrain.cut(), hit);
    EXPECT_EQ(place.i, 612.25);
    EXPECT_EQ(place.j, 20.75);
    EXPECT_NEAR(hitHeight(terrain.cut(), hit), 2 * place.i - 3 * place.j + 7, 1e-3);
}

}  // namespace
}  // namespace terray
