// SPDX-License-Identifier: Apache-2.0
// Walks a bundle of rays over the maxima: a box of cells per step, as large as stays clear.
#include "kernel/beam.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernel/pyramid.h"

namespace terray {
namespace {

constexpr int kMaxBeamSteps = 96;
constexpr float kLowest = -3.4e38f;
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// 2^n; std::ldexp is a call.
double powerOfTwo(int n) { return std::bit_cast<double>(static_cast<uint64_t>(1023 + n) << 52); }

}  // namespace

BeamWalk::BeamWalk(const TerrainCut& cut, const Beam& beam, const Sharp& sharp)
    : cut_(cut), beam_(beam), sharp_(sharp) {
    if (sharp.at <= 0) clearance_ += 1e-3 * static_cast<double>(cut.maxZ - cut.minZ);
    std::copy_n(beam.corners, 4, floor_);
    double nearest = 1e300, apart = 0;
    for (const Ray& a : beam.corners) {
        speed_ = std::max({speed_, std::fabs(a.dx), std::fabs(a.dy)});
        leastDx_ = std::min(leastDx_, a.dx - beam.bulge);
        mostDx_ = std::max(mostDx_, a.dx + beam.bulge);
        leastDy_ = std::min(leastDy_, a.dy - beam.bulge);
        mostDy_ = std::max(mostDy_, a.dy + beam.bulge);
        nearest = std::min(nearest, std::sqrt(a.bend));
        for (const Ray& b : beam.corners)
            apart = std::max(apart, std::fabs(std::sqrt(a.bend) - std::sqrt(b.bend)));
        fromOutside_ =
            fromOutside_ || a.x < 0.0 || a.y < 0.0 || a.x > cut.cellsX || a.y > cut.cellsY;
    }
    // bend = c |d_h|^2 is convex over the bundle: its least value may lie inside, but not far
    // below.
    const double least = std::max(0.0, nearest - 2.0 * apart);
    bend_ = least * least;
    level_ = std::min(cut_.rootLevel + kTileLevels, sharp.at > 0 ? kTileLevels : 12);
    here_ = frontAt(0.0);
}

BeamWalk::Front BeamWalk::frontAt(double w) const {
    Front f{{1e300, 1e300, -1e300, -1e300}, 1e300, 0};
    for (const Ray& r : beam_.corners) {
        const double x = r.x + r.dx * w, y = r.y + r.dy * w;
        f.box = {std::min(f.box.x0, x), std::min(f.box.y0, y), std::max(f.box.x1, x),
                 std::max(f.box.y1, y)};
    }
    for (const Ray& r : floor_) f.lowest = std::min(f.lowest, r.z + r.dz * w);
    const double bulge = beam_.bulge * w + 1e-6 * (1.0 + speed_ * w * 1e-6);
    f.box = {f.box.x0 - bulge, f.box.y0 - bulge, f.box.x1 + bulge, f.box.y1 + bulge};
    f.width = std::max(f.box.x1 - f.box.x0, f.box.y1 - f.box.y0);
    return f;
}

/// Beyond one of these sides, or the corners between them, finer or coarser tiles are drawn.
bool BeamWalk::bordersUnlike(const TileDesc& tile, int mip, const Sides& sides) const {
    const DirectoryLevel& row = cut_.levels[mip];
    const int64_t x = tile.x >> (kTileLevels + mip), y = tile.y >> (kTileLevels + mip);
    const int64_t x0 = sides.left ? x - 1 : x, x1 = sides.right ? x + 1 : x;
    const int64_t y0 = sides.top ? y - 1 : y, y1 = sides.bottom ? y + 1 : y;
    for (int64_t j = std::max<int64_t>(y0, 0); j <= std::min<int64_t>(y1, row.rows - 1); ++j)
        for (int64_t i = std::max<int64_t>(x0, 0); i <= std::min<int64_t>(x1, row.columns - 1);
             ++i) {
            const uint64_t index =
                row.offset + static_cast<uint64_t>(j) * row.columns + static_cast<uint64_t>(i);
            const uint32_t state = cut_.squares[index].state;
            if (state == kSquareCovered || state == kSquareDescend) return true;
        }
    return false;
}

/// A block of a drawn tile, no smaller than the pyramids know.
BeamWalk::Node BeamWalk::nodeInTile(const Square& square, int level, int64_t x, int64_t y) const {
    const TileDesc& tile = cut_.tiles[square.slot];
    const int mip = static_cast<int>(tile.mipFlags & kTileMipMask);
    const int least = sharp_.at > 0 ? kSharpestLevel : 1;
    const int inner = std::clamp(level - mip, least, kTileLevels), up = mip + inner - level;
    const int64_t n = kSlotCells >> inner;
    const int64_t i = (up > 0 ? x >> up : x << -up) & (n - 1);
    const int64_t j = (up > 0 ? y >> up : y << -up) & (n - 1);
    const auto index = static_cast<uint64_t>(j * n + i);
    Node node{kLowest, 0, mip};
    if (inner == kTileLevels) {
        node.top = square.maxZ;
    } else {
        const uint32_t code = cut_.bounds[tile.bounds + levelOffset(inner) + index];
        if ((code & 0xFFFFu) <= (code >> 16))
            node.top = tile.boundsZ0 + tile.boundsStep * static_cast<float>(code >> 16) +
                       1e-3f * tile.boundsStep;
    }
    if (sharp_.at <= 0) return node;
    const Sides sides{i == 0, i == n - 1, j == 0, j == n - 1};
    node.rim = cut_.unlikeMips != 0 && (sides.left || sides.right || sides.top || sides.bottom) &&
               bordersUnlike(tile, mip, sides);
    if (cut_.sharpness == nullptr || node.rim) {
        node.sharpest = kInfinity;
    } else {
        const uint8_t code =
            cut_.sharpness[uint64_t{square.slot} * kSlotSharpness + sharpnessOffset(inner) + index];
        node.sharpest = sharpnessOf(code) * static_cast<float>(powerOfTwo(-mip));
    }
    return node;
}

/// What is drawn in block (x, y) of 2^level cells a side, or in a larger block around it.
BeamWalk::Node BeamWalk::nodeAt(int level, int64_t x, int64_t y) const {
    int d = std::min(std::max(level - kTileLevels, 0), cut_.rootLevel);
    for (;; ++d) {
        const int shift = std::max(d + kTileLevels - level, 0);
        const DirectoryLevel& row = cut_.levels[d];
        const Square& square =
            cut_.squares[row.offset + static_cast<uint64_t>(y >> shift) * row.columns +
                         static_cast<uint64_t>(x >> shift)];
        if (square.state == kSquareCovered) continue;
        if (square.state == kSquareEmpty) return {kLowest, kInfinity, 0, false};
        if (square.state == kSquareDescend)
            return {square.maxZ, kInfinity, 0, cut_.unlikeMips != 0};
        return nodeInTile(square, level, x, y);
    }
}

/// Visits blocks that cover a box of cells, at most `across` a side.
template <class Visit>
void BeamWalk::eachNode(const Box& box, int across, const Visit& visit) const {
    const double sizeX = cut_.cellsX, sizeY = cut_.cellsY;
    if (box.x1 < 0.0 || box.y1 < 0.0 || box.x0 > sizeX || box.y0 > sizeY) return;
    const auto x0 = static_cast<int64_t>(std::max(box.x0, 0.0)),
               y0 = static_cast<int64_t>(std::max(box.y0, 0.0));
    const auto x1 = static_cast<int64_t>(std::min(box.x1, sizeX - 1.0)),
               y1 = static_cast<int64_t>(std::min(box.y1, sizeY - 1.0));
    int level = sharp_.at > 0 ? kSharpestLevel : 1;
    while (((x1 >> level) - (x0 >> level)) >= across || ((y1 >> level) - (y0 >> level)) >= across)
        ++level;
    if (level >= cut_.rootLevel + kTileLevels)
        return visit(Node{cut_.maxZ, kInfinity, 0, cut_.unlikeMips != 0});
    for (int64_t y = y0 >> level; y <= (y1 >> level); ++y)
        for (int64_t x = x0 >> level; x <= (x1 >> level); ++x) visit(nodeAt(level, x, y));
}

/// Greatest height that stands in the way in a box of cells.
float BeamWalk::maxOver(const Box& box, double sharp) const {
    if (sharp > 0) return sharpOver(box, sharp);
    float top = kLowest;
    eachNode(box, 2, [&](const Node& node) { top = std::max(top, node.top); });
    return top;
}

float BeamWalk::sharpOver(const Box& box, double sharp) const {
    constexpr int kAcross = 4;
    float top = kLowest;
    const bool gaps = fromOutside_ || cut_.unlikeMips != 0;
    // What rises from the rim or beyond a border stands in the next cell: one cell around, and any
    // height there. What rises from a hole stands in a cell that is sharp itself.
    for (double around = gaps ? 1 : 0;;) {
        const Box wide{box.x0 - around, box.y0 - around, box.x1 + around, box.y1 + around};
        bool gap = fromOutside_ && (wide.x0 < 0.0 || wide.y0 < 0.0 || wide.x1 > cut_.cellsX ||
                                    wide.y1 > cut_.cellsY);
        float any = kLowest;
        double cell = 1;
        top = kLowest;
        eachNode(wide, kAcross, [&](const Node& node) {
            if (static_cast<double>(node.sharpest) >= sharp) top = std::max(top, node.top);
            gap = gap || node.rim;
            any = std::max(any, node.top);
            cell = std::max(cell, powerOfTwo(node.mip));
        });
        if (!gaps || cell <= around) return gap ? any : top;
        around = cell;
    }
}

/// The bundle is beyond the terrain's rectangle and goes away from it.
bool BeamWalk::hasLeft(const Box& box) const {
    return (box.x0 > cut_.cellsX && leastDx_ >= 0) || (box.x1 < 0 && mostDx_ <= 0) ||
           (box.y0 > cut_.cellsY && leastDy_ >= 0) || (box.y1 < 0 && mostDy_ <= 0);
}

void BeamWalk::raiseFloor(const Ray& left, const Ray& right) {
    floor_[0] = floor_[2] = left;
    floor_[1] = floor_[3] = right;
    here_ = frontAt(w_);
    stopped_ = false;
}

double BeamWalk::clearTo(double wanted) {
    for (int step = 0; !stopped_ && w_ < wanted; ++step) {
        const double size = powerOfTwo(level_);
        const double next = w_ + size / speed_;
        const Front there = frontAt(next);
        const Box box{std::min(here_.box.x0, there.box.x0), std::min(here_.box.y0, there.box.y0),
                      std::max(here_.box.x1, there.box.x1), std::max(here_.box.y1, there.box.y1)};
        const double lowest = std::min(here_.lowest, there.lowest) + bend_ * w_ * w_;
        if (lowest > static_cast<double>(maxOver(box, sharp_.least(next))) + clearance_) {
            w_ = next;
            const bool rising = there.lowest > here_.lowest;
            here_ = there;
            if (lowest > static_cast<double>(cut_.maxZ) + clearance_ && rising) w_ = kNever;
            if (hasLeft(there.box)) w_ = kNever;
            ++level_;
        } else {
            stopped_ = level_ <= (sharp_.at > 0 ? kSharpestLevel : 1) || size < 0.5 * there.width;
            if (!stopped_) --level_;
        }
        if (step == kMaxBeamSteps) break;
    }
    return w_;
}

}  // namespace terray
