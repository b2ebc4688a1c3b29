// SPDX-License-Identifier: Apache-2.0
// Small hand-made cuts for tests: heights in an array, tiles of chosen mips side by side, holes,
// both post formats.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "kernel/layout/layout.h"

namespace terray::test {

/// Posts of mip 0, row-major; NaN for a hole.
struct Heights {
    int columns = 2, rows = 2;
    std::vector<float> z = std::vector<float>(4);

    Heights() = default;
    Heights(int columnCount, int rowCount, const std::function<double(int, int)>& height);
    float& at(int i, int j) { return z[index(i, j)]; }
    float at(int i, int j) const { return z[index(i, j)]; }

private:
    size_t index(int i, int j) const {
        return static_cast<size_t>(j) * static_cast<size_t>(columns) + static_cast<size_t>(i);
    }
};

struct CutChoice {
    bool int16 = false;  ///< 16-bit codes; heights are rounded to the nearest code
    double zStep = 0;    ///< metres a code; 0: the range over 65534
    SurfaceKind surface = kSurfaceBilinear;
    /// Mip wanted for the tile (x, y) of mip 0; a coarser tile is drawn where all below it want it.
    std::function<int(int, int)> mipOfTile = [](int, int) { return 0; };
};

constexpr SurfaceKind kAllSurfaces[] = {kSurfaceBilinear, kSurfaceConstant, kSurfaceTriangles};

/// A cut that owns its pools: every tile of every mip is resident.
class TestCut {
public:
    explicit TestCut(const Heights& heights, const CutChoice& choice = {});
    TestCut(const TestCut&) = delete;
    TestCut& operator=(const TestCut&) = delete;

    const TerrainCut& cut() const { return cut_; }
    void setSurface(SurfaceKind surface) { cut_.surface = surface; }
    uint32_t slotOf(int mip, int x, int y) const;

private:
    void layOutLevels(const Heights& heights);
    void fillTile(const Heights& posts, int mip, int x, int y, uint32_t slot);
    bool drawSquares(int level, int x, int y, const CutChoice& choice);
    int wantedMip(int level, int x, int y, const CutChoice& choice) const;
    void encode(const Heights& heights, const CutChoice& choice);
    Square& square(int level, uint32_t x, uint32_t y);

    TerrainCut cut_;
    float z0_ = 0, zStep_ = 0;
    std::vector<TileDesc> tiles_;
    std::vector<float> floatPosts_;
    std::vector<uint16_t> codes_;
    std::vector<uint32_t> bounds_;
    std::vector<Square> squares_;
};

/// Posts of the next mip: the weighted mean of the 3 x 3 around the post below, which must be
/// valid.
Heights coarserHeights(const Heights& fine);

// ---- Terrains ----------------------------------------------------------------------------------

/// Smooth hash noise in 0..1, octaves added: rough at every scale. Seeded.
Heights roughTerrain(int columns, int rows, double amplitude, uint32_t seed);
/// Gentle ground with blocks of `step` metres standing on it, cliffs between neighbouring posts.
Heights townTerrain(int columns, int rows, double step, uint32_t seed);
/// Turns single posts and a few rectangles into holes.
void punchHoles(Heights& heights, int count, uint32_t seed);

}  // namespace terray::test
