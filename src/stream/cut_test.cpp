// SPDX-License-Identifier: Apache-2.0
// Tests of cuts: the directory covers every place once, bounds hold, detail follows the eye.
#include "stream/cut.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "kernel/height.h"
#include "stream/test_source.h"

namespace terray {
namespace {

using test::ArraySource;
using test::built;
using test::hills;

Camera lookingNorth(const ResidentTerrain& terrain, double i, double j, double z) {
    const Vec2 place = terrain.info().worldFromLattice.worldFromLattice({i, j});
    Camera camera;
    camera.width = 640;
    camera.height = 360;
    camera.eye = {place.x, place.y, z};
    camera.right = {1, 0, 0};
    camera.forward = {0, 1, 0};
    camera.up = {0, 0, 1};
    return camera;
}

/// Squares with a state over a lattice place, found without walking down.
int drawnOver(const TerrainCut& cut, double i, double j) {
    int drawn = 0;
    for (int level = 0; level <= cut.rootLevel; ++level) {
        const auto x = static_cast<uint32_t>(i) >> (9 + level);
        const auto y = static_cast<uint32_t>(j) >> (9 + level);
        const DirectoryLevel& grid = cut.levels[level];
        if (cut.squares[grid.offset + y * grid.columns + x].state == kSquareDrawn) ++drawn;
    }
    return drawn;
}

int mipAt(const TerrainCut& cut, double i, double j) { return surfaceCellAt(cut, i, j).mip; }

void expectWellFormed(const TerrainCut& cut, int level, uint32_t x, uint32_t y, bool covered) {
    const DirectoryLevel& grid = cut.levels[level];
    if (x >= grid.columns || y >= grid.rows) return;
    const Square& square = cut.squares[grid.offset + y * grid.columns + x];
    if (covered) {
        EXPECT_EQ(square.state, kSquareCovered);
    } else {
        EXPECT_NE(square.state, kSquareCovered);
        EXPECT_TRUE(level > 0 || square.state != kSquareDescend);
    }
    if (level == 0) return;
    const bool below = covered || square.state == kSquareDrawn;
    for (uint32_t child = 0; child < 4; ++child) {
        const uint32_t childX = 2 * x + child % 2, childY = 2 * y + child / 2;
        const DirectoryLevel& finer = cut.levels[level - 1];
        if (childX >= finer.columns || childY >= finer.rows) continue;
        const Square& inside = cut.squares[finer.offset + childY * finer.columns + childX];
        if (square.state == kSquareDescend && !covered && inside.state != kSquareEmpty) {
            EXPECT_LE(square.minZ, inside.minZ);
            EXPECT_GE(square.maxZ, inside.maxZ);
        }
        if (square.state != kSquareEmpty) {
            expectWellFormed(cut, level - 1, childX, childY, below);
        }
    }
}

TEST(SelectCut, EveryPlaceIsDrawnOnceAndWithinItsBounds) {
    for (const bool holes : {false, true}) {
        const ArraySource source(3000, 2100, PostFormat::Int16, hills(1, holes));
        const auto terrain = built(source);
        for (const double tolerance : {0.0, 1.0, 8.0, 200.0}) {
            CutOptions options;
            options.tolerancePx = tolerance;
            const Camera camera = lookingNorth(*terrain, 700, 1900, 650);
            const FrameCut frame = selectCut(*terrain, camera, options);
            const TerrainCut& cut = frame.cut();
            expectWellFormed(cut, cut.rootLevel, 0, 0, false);
            for (double j = 0.7; j < 2099; j += 13.3) {
                for (double i = 0.2; i < 2999; i += 17.9) {
                    ASSERT_EQ(drawnOver(cut, i, j), 1);
                    const SurfaceCell cell = surfaceCellAt(cut, i, j);
                    if (cell.slot == kNoSlot) continue;
                    const double z = cell.height(kSurfaceBilinear);
                    ASSERT_GE(z, static_cast<double>(cut.minZ));
                    ASSERT_LE(z, static_cast<double>(cut.maxZ));
                    ASSERT_LE(std::abs(cell.h00 - cell.h11), cut.maxDelta);
                    ASSERT_LE(std::abs(cell.h10 - cell.h11), cut.maxDelta);
                }
            }
        }
    }
}

TEST(SelectCut, DrawnErrorIsBounded) {
    const ArraySource source(3000, 2100, PostFormat::Float32, hills(2, false));
    const auto terrain = built(source);
    CutOptions options;
    options.tolerancePx = 4;
    const FrameCut frame = selectCut(*terrain, lookingNorth(*terrain, 300, 2000, 700), options);
    const FrameCut finest = finestCut(*terrain, kSurfaceBilinear);
    EXPECT_GT(frame.cut().maxError, 0);
    EXPECT_EQ(finest.cut().maxError, 0);
    for (double j = 0.7; j < 2099; j += 11.3) {
        for (double i = 0.2; i < 2999; i += 7.9) {
            const double error =
                std::abs(surfaceCellAt(frame.cut(), i, j).height(kSurfaceBilinear) -
                         surfaceCellAt(finest.cut(), i, j).height(kSurfaceBilinear));
            ASSERT_LE(error, static_cast<double>(frame.cut().maxError));
        }
    }
}

TEST(SelectCut, ToleranceZeroIsTheFinestMip) {
    const ArraySource source(1500, 1100, PostFormat::Int16, hills(3, true));
    const auto terrain = built(source);
    CutOptions options;
    options.tolerancePx = 0;
    const FrameCut frame = selectCut(*terrain, lookingNorth(*terrain, 0, 0, 1e7), options);
    EXPECT_EQ(frame.tilesPerMip(), (std::vector<uint64_t>{9, 0, 0}));
    EXPECT_EQ(frame.cut().maxError, 0);
}

TEST(SelectCut, DetailFallsWithDistanceAndTolerance) {
    const ArraySource source(4097, 1025, PostFormat::Float32, hills(4, false));
    const auto terrain = built(source);
    CutOptions options;
    options.tolerancePx = 2;
    const Camera camera = lookingNorth(*terrain, 10, 500, 620);
    const FrameCut frame = selectCut(*terrain, camera, options);
    EXPECT_EQ(mipAt(frame.cut(), 20, 500), 0);
    EXPECT_GT(mipAt(frame.cut(), 4000, 500), 0);
    int last = 0;
    for (double i = 100; i < 4096; i += 512) {
        EXPECT_GE(mipAt(frame.cut(), i, 500), last);
        last = mipAt(frame.cut(), i, 500);
    }
    uint64_t tiles = ~uint64_t{0};
    for (const double tolerance : {0.5, 2.0, 8.0, 1000.0}) {
        options.tolerancePx = tolerance;
        uint64_t drawn = 0;
        const FrameCut cut = selectCut(*terrain, camera, options);
        for (const uint64_t count : cut.tilesPerMip()) drawn += count;
        EXPECT_LE(drawn, tiles);
        tiles = drawn;
    }
}

uint64_t finestTiles(const ResidentTerrain& terrain, const Camera& camera,
                     const CutOptions& options) {
    return selectCut(terrain, camera, options).tilesPerMip()[0];
}

TEST(SelectCut, ExaggerationConstantCellsAndShadowsAskForMoreDetail) {
    const ArraySource source(4097, 2049, PostFormat::Float32, hills(5, false));
    const auto terrain = built(source);
    Camera camera = lookingNorth(*terrain, 50, 1000, 900);
    camera.projection = Projection::Panorama;
    CutOptions options;
    options.tolerancePx = 0.35;
    const uint64_t plain = finestTiles(*terrain, camera, options);
    EXPECT_LT(plain, 32u);

    CutOptions constant = options;
    constant.surface = kSurfaceConstant;
    EXPECT_GT(finestTiles(*terrain, camera, constant), plain);

    CutOptions shadows = options;
    shadows.sun = SunBound{{0, -0.999, 0.045}};
    EXPECT_GT(finestTiles(*terrain, camera, shadows), plain);
    shadows.sun = SunBound{{0, 0, 1}};
    EXPECT_EQ(finestTiles(*terrain, camera, shadows), plain);
    shadows.sun = SunBound{{0.7, 0, -0.7}};
    EXPECT_EQ(finestTiles(*terrain, camera, shadows), plain);

    CutOptions exaggerated = options;
    exaggerated.exaggeration = 4;
    Camera high = camera;
    high.eye.z *= 4;
    EXPECT_GT(finestTiles(*terrain, high, exaggerated), plain);
}

TEST(SelectCut, UnseenGroundIsCoarseUnlessItsShadowIsSeen) {
    // A ridge far off in the west, on plain ground that is seen.
    const ArraySource source(8193, 2049, PostFormat::Float32, [](int64_t i, int64_t j) {
        const bool ridge = i > 200 && i < 500 && j > 900 && j < 1100;
        return ridge ? 900.0f + static_cast<float>((i * 7919 + j * 104729) % 97) : 0.0f;
    });
    const auto terrain = built(source);
    Camera camera = lookingNorth(*terrain, 1300, 1000, 3000);
    camera.forward = {0, 0, -1};
    camera.up = {0, 1, 0};
    CutOptions options;
    options.tolerancePx = 1;
    EXPECT_GT(mipAt(selectCut(*terrain, camera, options).cut(), 350, 1000), 2);
    options.sun = SunBound{{-0.95, 0, 0.3}};
    EXPECT_LT(mipAt(selectCut(*terrain, camera, options).cut(), 350, 1000), 2);
    options.sun = SunBound{{0.95, 0, 0.3}};
    EXPECT_GT(mipAt(selectCut(*terrain, camera, options).cut(), 350, 1000), 2);
}

TEST(SelectCut, OrthoDetailFollowsThePixelSize) {
    const ArraySource source(2049, 2049, PostFormat::Int16, hills(6, false));
    const auto terrain = built(source);
    Camera camera = lookingNorth(*terrain, 1024, 1024, 1e5);
    camera.projection = Projection::Ortho;
    camera.forward = {0, 0, -1};
    camera.up = {0, 1, 0};
    CutOptions options;
    camera.orthoSize = {640, 360};
    EXPECT_EQ(selectCut(*terrain, camera, options).tilesPerMip()[0], 16u);
    camera.orthoSize = {6.4e6, 3.6e6};
    EXPECT_EQ(selectCut(*terrain, camera, options).tilesPerMip().back(), 1u);
}

TEST(SelectCut, RimsOfHolesKeepTheirPlace) {
    // Flat ground has no height error: only the rims ask for detail, and only near the eye.
    const ArraySource source(4097, 2049, PostFormat::Float32, [](int64_t i, int64_t j) {
        const bool near = std::hypot(double(i) - 300, double(j) - 250) < 100;
        const bool far = std::hypot(double(i) - 3800, double(j) - 1800) < 100;
        return near || far ? test::kNaN : 10.0f;
    });
    const auto terrain = built(source);
    CutOptions options;
    options.tolerancePx = 2;
    const FrameCut frame = selectCut(*terrain, lookingNorth(*terrain, 300, 400, 30), options);
    EXPECT_EQ(mipAt(frame.cut(), 300, 380), 0);
    EXPECT_GT(mipAt(frame.cut(), 3800, 1500), 0);
    EXPECT_LT(frame.cut().maxError, 1e-5f);  // rounding alone
}

}  // namespace
}  // namespace terray
