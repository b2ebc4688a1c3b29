// SPDX-License-Identifier: Apache-2.0
// Walks a bundle of rays over the maxima: a box of cells per step, as large as stays clear.
#include "kernel/beam.h"

#include <algorithm>
#include <cmath>

namespace terray {
namespace {

constexpr int kMaxBeamSteps = 96;

struct Box {
    double x0, y0, x1, y1;
};

/// What the corners do at one w: their box, lowest height, and how far apart they are.
struct Front {
    Box box;
    double lowest;
    double width;
};

class BeamWalker {
public:
    BeamWalker(const TerrainCut& cut, const Beam& beam) : cut_(cut), beam_(beam) {
        clearance_ += 1e-3 * static_cast<double>(cut.maxZ - cut.minZ);
        double nearest = 1e300, apart = 0;
        for (const Ray& a : beam.corners) {
            speed_ = std::max({speed_, std::fabs(a.dx), std::fabs(a.dy)});
            nearest = std::min(nearest, std::sqrt(a.bend));
            for (const Ray& b : beam.corners)
                apart = std::max(apart, std::fabs(std::sqrt(a.bend) - std::sqrt(b.bend)));
        }
        // bend = c |d_h|^2 is convex over the bundle: its least value may lie inside, but not far
        // below.
        const double least = std::max(0.0, nearest - 2.0 * apart);
        bend_ = least * least;
    }

    BeamStart walk();

private:
    Front frontAt(double w) const;
    float maxOver(const Box& box) const;
    float maxOfNode(int level, int64_t x, int64_t y) const;

    const TerrainCut& cut_;
    const Beam& beam_;
    double speed_ = 1e-12, bend_ = 0;
    /// Rays begin well outside the float rays' error, where their first cells can be told.
    double clearance_ = 1e-3;
};

Front BeamWalker::frontAt(double w) const {
    Front f{{1e300, 1e300, -1e300, -1e300}, 1e300, 0};
    for (const Ray& r : beam_.corners) {
        const double x = r.x + r.dx * w, y = r.y + r.dy * w;
        f.box = {std::min(f.box.x0, x), std::min(f.box.y0, y), std::max(f.box.x1, x),
                 std::max(f.box.y1, y)};
        f.lowest = std::min(f.lowest, r.z + r.dz * w);
    }
    const double bulge = beam_.bulge * w + 1e-6 * (1.0 + speed_ * w * 1e-6);
    f.box = {f.box.x0 - bulge, f.box.y0 - bulge, f.box.x1 + bulge, f.box.y1 + bulge};
    f.width = std::max(f.box.x1 - f.box.x0, f.box.y1 - f.box.y0);
    return f;
}

/// Greatest height drawn in block (x, y) of 2^level cells a side, or of a larger block around it.
float BeamWalker::maxOfNode(int level, int64_t x, int64_t y) const {
    int d = std::min(std::max(level - kTileLevels, 0), cut_.rootLevel);
    for (;; ++d) {
        const int shift = std::max(d + kTileLevels - level, 0);
        const DirectoryLevel& row = cut_.levels[d];
        const Square& square =
            cut_.squares[row.offset + static_cast<uint64_t>(y >> shift) * row.columns +
                         static_cast<uint64_t>(x >> shift)];
        if (square.state == kSquareCovered) continue;
        if (square.state == kSquareEmpty) return -3.4e38f;
        if (square.state == kSquareDescend || level >= d + kTileLevels) return square.maxZ;
        const TileDesc& tile = cut_.tiles[square.slot];
        const int mip = static_cast<int>(tile.mipFlags & kTileMipMask);
        const int inner = std::max(level - mip, 1), up = std::max(mip + 1 - level, 0);
        const int64_t n = kSlotCells >> inner;
        const uint32_t code =
            cut_.bounds[tile.bounds + levelOffset(inner) +
                        static_cast<uint64_t>(((y >> up) & (n - 1)) * n + ((x >> up) & (n - 1)))];
        if ((code & 0xFFFFu) > (code >> 16)) return -3.4e38f;
        return tile.boundsZ0 + tile.boundsStep * static_cast<float>(code >> 16) +
               1e-3f * tile.boundsStep;
    }
}

/// Greatest height drawn in a box of cells: at most 2 x 2 blocks cover it.
float BeamWalker::maxOver(const Box& box) const {
    const double sizeX = cut_.cellsX, sizeY = cut_.cellsY;
    if (box.x1 < 0.0 || box.y1 < 0.0 || box.x0 > sizeX || box.y0 > sizeY) return -3.4e38f;
    const auto x0 = static_cast<int64_t>(std::max(box.x0, 0.0)),
               y0 = static_cast<int64_t>(std::max(box.y0, 0.0));
    const auto x1 = static_cast<int64_t>(std::min(box.x1, sizeX - 1.0)),
               y1 = static_cast<int64_t>(std::min(box.y1, sizeY - 1.0));
    int level = 1;
    while (((x1 >> level) - (x0 >> level)) > 1 || ((y1 >> level) - (y0 >> level)) > 1) ++level;
    if (level >= cut_.rootLevel + kTileLevels) return cut_.maxZ;
    float top = -3.4e38f;
    for (int64_t y = y0 >> level; y <= (y1 >> level); ++y)
        for (int64_t x = x0 >> level; x <= (x1 >> level); ++x)
            top = std::max(top, maxOfNode(level, x, y));
    return top;
}

BeamStart BeamWalker::walk() {
    BeamStart start;
    int level = std::min(cut_.rootLevel + kTileLevels, 12);
    Front here = frontAt(0.0);
    for (int step = 0; step < kMaxBeamSteps; ++step) {
        const double size = std::ldexp(1.0, level);
        const double next = start.w + size / speed_;
        const Front there = frontAt(next);
        const Box box{std::min(here.box.x0, there.box.x0), std::min(here.box.y0, there.box.y0),
                      std::max(here.box.x1, there.box.x1), std::max(here.box.y1, there.box.y1)};
        const double lowest = std::min(here.lowest, there.lowest) + bend_ * start.w * start.w;
        start.level = level;
        if (lowest > static_cast<double>(maxOver(box)) + clearance_) {
            start.w = next;
            here = there;
            if (lowest > static_cast<double>(cut_.maxZ) + clearance_ && there.lowest > here.lowest)
                break;
            ++level;
        } else {
            if (level <= 1 || size < 0.5 * there.width) break;
            --level;
        }
    }
    return start;
}

}  // namespace

BeamStart beamStart(const TerrainCut& cut, const Beam& beam) {
    return BeamWalker(cut, beam).walk();
}

}  // namespace terray
