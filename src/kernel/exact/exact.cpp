// SPDX-License-Identifier: Apache-2.0
// Double-precision traversal: squares of the directory, then blocks of a tile's pyramid, then
// cells.
#include "kernel/exact/exact.h"

#include <algorithm>
#include <cmath>

#include "kernel/exact/cell.h"

namespace terray::exact {
namespace {

constexpr double kHuge = 1e300;
constexpr double kNudge =
    1e-7;  ///< cells: past a quadrant's border, which float places miss by less
constexpr uint32_t kMaxSteps = 0xFFFF;

/// An axis-aligned block of cells of one mip, [x, x + size) in cells of that mip.
struct Block {
    int64_t x, y, size;
};

struct Exit {
    double t;
    bool alongX;  ///< leaves through a border of constant x
};

class Walker {
public:
    Walker(const TerrainCut& cut, const Ray& ray) : cut_(cut), ray_(ray) {
        vertex_ = ray.bend > 0.0 ? -ray.dz / (2.0 * ray.bend) : (ray.dz < 0.0 ? kHuge : -kHuge);
    }

    Hit walk();
    bool walkFrom(const Hit& start);

private:
    struct DrawnSquare {
        uint32_t slot = kNoSlot;
        int mip = 0;
        bool empty = true;
    };

    DrawnSquare squareAt(int64_t i, int64_t j) const;
    const Square& square(int level, int64_t i, int64_t j) const {
        const DirectoryLevel& l = cut_.levels[level];
        return cut_.squares[l.offset + static_cast<uint64_t>(j >> (9 + level)) * l.columns +
                            static_cast<uint64_t>(i >> (9 + level))];
    }
    Exit exitOf(const Block& block, int mip) const;
    bool misses(double t0, double t1, double lo, double hi) const;
    int64_t cellAlong(double start, double step, double t, int mip, int64_t lo, int64_t hi) const;
    bool run();
    bool walkTile(const DrawnSquare& here);
    bool leavesSheet(Cell cell, double u, double v, double side);
    bool leavesQuadrantWall(const Hit& start, const Cell& cell, bool wallX, bool wallY,
                            double side);
    bool leavesWall(const Hit& start, const Cell& cell);
    double pastWalls(int mip, bool wallX, bool wallY) const;
    double quadrantExit(const Cell& cell, double u, double v) const;
    bool testCell(uint32_t slot, int64_t x, int64_t y, double tEnd);
    bool testBilinear(const Cell& cell, double tEnd);
    bool testConstant(const Cell& cell, double tEnd);
    bool testTriangles(const Cell& cell, double tEnd);
    bool testRest(const Cell& cell, double tEnd) {
        return cut_.surface == kSurfaceConstant ? testConstant(cell, tEnd)
                                                : testTriangles(cell, tEnd);
    }
    double heightIn(const Cell& cell, double u, double v) const {
        if (cut_.surface == kSurfaceConstant) return quadrantHeight(cell, u, v);
        return cut_.surface == kSurfaceTriangles ? triangular(cell, u, v) : bilinear(cell, u, v);
    }
    bool testBorder(const DrawnSquare& before, const DrawnSquare& here);
    void advance(const Block& block, int mip, const Exit& exit);
    double signedHeight(uint32_t slot, double t, int64_t i, int64_t j) const;
    void record(const Cell& cell, double t, bool fromBelow, bool strip);
    /// Keeps a hit's place on its own side of the quadrants' borders.
    void keepQuadrant(bool right, bool lower) {
        const float belowHalf = std::nextafter(0.5f, 0.0f);
        hit_.u = right ? std::max(hit_.u, 0.5f) : std::min(hit_.u, belowHalf);
        hit_.v = lower ? std::max(hit_.v, 0.5f) : std::min(hit_.v, belowHalf);
    }
    double quadrantHeight(const Cell& c, double u, double v) const {
        return v >= 0.5 ? (u >= 0.5 ? c.h11 : c.h01) : (u >= 0.5 ? c.h10 : c.h00);
    }

    const TerrainCut& cut_;
    const Ray& ray_;
    double vertex_;
    double t_ = 0, tEnd_ = 0;
    int64_t i_ = 0, j_ = 0;          ///< mip-0 cell the ray stands in
    int64_t lastI_ = 0, lastJ_ = 0;  ///< the cell it came from
    double carried_ = 0;             ///< f at t_ as the last tested cell saw it, 0 if unknown
    uint32_t steps_ = 0;
    Hit hit_{};
};

Walker::DrawnSquare Walker::squareAt(int64_t i, int64_t j) const {
    for (int level = cut_.rootLevel; level >= 0; --level) {
        const Square& s = square(level, i, j);
        if (s.state == kSquareDescend) continue;
        return {s.slot, level, s.state != kSquareDrawn};
    }
    return {};
}

Exit Walker::exitOf(const Block& block, int mip) const {
    const CellRay r = cellRay(ray_, mip);
    const double bx = static_cast<double>(r.dx > 0 ? block.x + block.size : block.x);
    const double by = static_cast<double>(r.dy > 0 ? block.y + block.size : block.y);
    const double tx = r.dx != 0.0 ? (bx - r.x) / r.dx : kHuge;
    const double ty = r.dy != 0.0 ? (by - r.y) / r.dy : kHuge;
    return {std::max(std::min(tx, ty), t_), tx <= ty};
}

/// True if the ray stays above `hi` or below `lo` for all of [t0, t1].
bool Walker::misses(double t0, double t1, double lo, double hi) const {
    const double slack = 1e-9 * (1.0 + std::fabs(ray_.z) + std::fabs(hi));
    const double lowest = rayHeight(ray_, std::clamp(vertex_, t0, t1));
    if (lowest > hi + slack) return true;
    return std::max(rayHeight(ray_, t0), rayHeight(ray_, t1)) < lo - slack;
}

int64_t Walker::cellAlong(double start, double step, double t, int mip, int64_t lo,
                          int64_t hi) const {
    // Truncation is floor from 0 on; what lies before is clamped anyway.
    const double place = (start + step * t) / static_cast<double>(1u << mip);
    return std::clamp(static_cast<int64_t>(std::clamp(place, -1.0, 4e18)), lo, hi);
}

/// Moves to the border of a block: the coordinate across it is set, not computed.
void Walker::advance(const Block& block, int mip, const Exit& exit) {
    lastI_ = i_;
    lastJ_ = j_;
    t_ = exit.t;
    const int64_t x0 = block.x << mip, y0 = block.y << mip, size = block.size << mip;
    if (exit.alongX) {
        i_ = ray_.dx > 0 ? x0 + size : x0 - 1;
        j_ = cellAlong(ray_.y, ray_.dy, t_, 0, y0, std::min(y0 + size, int64_t{cut_.cellsY}) - 1);
        lastI_ = ray_.dx > 0 ? i_ - 1 : i_ + 1;
        lastJ_ = j_;
    } else {
        j_ = ray_.dy > 0 ? y0 + size : y0 - 1;
        i_ = cellAlong(ray_.x, ray_.dx, t_, 0, x0, std::min(x0 + size, int64_t{cut_.cellsX}) - 1);
        lastJ_ = ray_.dy > 0 ? j_ - 1 : j_ + 1;
        lastI_ = i_;
    }
}

void Walker::record(const Cell& cell, double t, bool fromBelow, bool strip) {
    const CellRay r = cellRay(ray_, cell.mip);
    hit_.t = static_cast<float>(t);
    hit_.tile = cell.slot;
    hit_.cell = static_cast<uint32_t>((cell.y & 511) * 512 + (cell.x & 511));
    hit_.u = static_cast<float>(std::clamp(r.x + r.dx * t - static_cast<double>(cell.x), 0.0, 1.0));
    hit_.v = static_cast<float>(std::clamp(r.y + r.dy * t - static_cast<double>(cell.y), 0.0, 1.0));
    hit_.mip = static_cast<uint8_t>(cell.mip);
    hit_.flags =
        static_cast<uint8_t>(kHitValid | (fromBelow ? kHitFromBelow : 0) | (strip ? kHitStrip : 0));
}

bool Walker::testBilinear(const Cell& cell, double tEnd) {
    const CellRay r = cellRay(ray_, cell.mip);
    const auto place = [&](double t, double& u, double& v) {
        u = std::clamp(r.x + r.dx * t - static_cast<double>(cell.x), 0.0, 1.0);
        v = std::clamp(r.y + r.dy * t - static_cast<double>(cell.y), 0.0, 1.0);
    };
    double u, v, uEnd, vEnd;
    place(t_, u, v);
    place(tEnd, uEnd, vEnd);
    Quadratic q = cellQuadratic(cell, ray_, t_, u, v);
    const double fEnd = rayHeight(ray_, tEnd) - bilinear(cell, uEnd, vEnd);
    if (carried_ != 0.0 && q.f0 != 0.0 && (carried_ > 0.0) != (q.f0 > 0.0)) {
        record(cell, t_, carried_ < 0.0, false);  // the edge itself is where the sign changed
        return true;
    }
    if (const auto s = firstRoot(q, tEnd - t_, fEnd)) {
        const bool below =
            q.f0 != 0.0 ? q.f0 < 0.0 : (carried_ != 0.0 ? carried_ < 0.0 : q.f1 > 0.0);
        record(cell, t_ + *s, below, false);
        return true;
    }
    carried_ = fEnd;
    return false;
}

/// Nearest post: up to three quadrants in the order of the ray, with the walls between them.
bool Walker::testConstant(const Cell& cell, double tEnd) {
    const CellRay r = cellRay(ray_, cell.mip);
    const double tu = r.dx != 0.0 ? (static_cast<double>(cell.x) + 0.5 - r.x) / r.dx : kHuge;
    const double tv = r.dy != 0.0 ? (static_cast<double>(cell.y) + 0.5 - r.y) / r.dy : kHuge;
    const double cuts[4] = {t_, std::clamp(std::min(tu, tv), t_, tEnd),
                            std::clamp(std::max(tu, tv), t_, tEnd), tEnd};
    for (int k = 0; k < 3; ++k) {
        if (cuts[k + 1] <= cuts[k] && !(k == 0 && cuts[3] <= cuts[0])) continue;
        // By the order of the crossings, which rounding of a place cannot turn round.
        const bool right = r.dx == 0.0 ? r.x - static_cast<double>(cell.x) >= 0.5
                                       : (r.dx > 0.0) == (tu <= cuts[k]);
        const bool lower = r.dy == 0.0 ? r.y - static_cast<double>(cell.y) >= 0.5
                                       : (r.dy > 0.0) == (tv <= cuts[k]);
        const double h = quadrantHeight(cell, right ? 1.0 : 0.0, lower ? 1.0 : 0.0);
        const double f0 = rayHeight(ray_, cuts[k]) - h, f1 = rayHeight(ray_, cuts[k + 1]) - h;
        if (carried_ != 0.0 && f0 != 0.0 && (carried_ > 0.0) != (f0 > 0.0)) {
            record(cell, cuts[k], carried_ < 0.0, true);
            keepQuadrant(right, lower);
            return true;
        }
        const Quadratic q{f0, ray_.dz + 2.0 * ray_.bend * cuts[k], ray_.bend};
        if (const auto s = firstRoot(q, cuts[k + 1] - cuts[k], f1)) {
            record(cell, cuts[k] + *s, f0 != 0.0 ? f0 < 0.0 : carried_ < 0.0, false);
            keepQuadrant(right, lower);
            return true;
        }
        carried_ = f1;
    }
    return false;
}

/// Two planes: up to two parts in the order of the ray, with one height where they meet.
bool Walker::testTriangles(const Cell& cell, double tEnd) {
    const CellRay r = cellRay(ray_, cell.mip);
    const auto placeU = [&](double t) {
        return std::clamp(r.x + r.dx * t - static_cast<double>(cell.x), 0.0, 1.0);
    };
    const auto placeV = [&](double t) {
        return std::clamp(r.y + r.dy * t - static_cast<double>(cell.y), 0.0, 1.0);
    };
    const double cuts[3] = {t_, std::clamp(diagonalTime(cell, r), t_, tEnd), tEnd};
    const bool meets = cuts[1] > cuts[0] && cuts[1] < cuts[2];
    const double v1 = placeV(cuts[1]);
    const double onDiagonal = cell.h10 + (cell.h01 - cell.h10) * v1;
    const auto f = [&](double t) {
        return rayHeight(ray_, t) - triangular(cell, placeU(t), placeV(t));
    };
    double f0 = f(cuts[0]);
    if (carried_ != 0.0 && f0 != 0.0 && (carried_ > 0.0) != (f0 > 0.0)) {
        record(cell, t_, carried_ < 0.0, false);  // the edge itself is where the sign changed
        return true;
    }
    for (int k = meets ? 0 : 1; k < 2; ++k) {
        const double from = meets ? cuts[k] : cuts[0], to = cuts[k + 1];
        const double mid = 0.5 * (from + to);
        const double slope = triangleSlope(cell, r, placeU(mid) + placeV(mid) > 1.0);
        const double f1 = k == 0 ? rayHeight(ray_, to) - onDiagonal : f(to);
        const Quadratic q{f0, ray_.dz + 2.0 * ray_.bend * from - slope, ray_.bend};
        if (const auto s = firstRoot(q, to - from, f1)) {
            const bool below =
                f0 != 0.0 ? f0 < 0.0 : (carried_ != 0.0 ? carried_ < 0.0 : q.f1 > 0.0);
            record(cell, from + *s, below, false);
            return true;
        }
        carried_ = f0 = f1;
    }
    return false;
}

bool Walker::testCell(uint32_t slot, int64_t x, int64_t y, double tEnd) {
    const Cell cell = loadCell(cut_, slot, x, y);
    if (!cell.valid) {
        carried_ = 0.0;
        return false;
    }
    return cut_.surface == kSurfaceBilinear ? testBilinear(cell, tEnd) : testRest(cell, tEnd);
}

/// f at time t in the cell of a tile that holds the mip-0 cell (i, j); 0 in a hole.
double Walker::signedHeight(uint32_t slot, double t, int64_t i, int64_t j) const {
    const int mip = static_cast<int>(cut_.tiles[slot].mipFlags & kTileMipMask);
    const Cell cell = loadCell(cut_, slot, i >> mip, j >> mip);
    if (!cell.valid) return 0.0;
    const CellRay r = cellRay(ray_, mip);
    const double u = std::clamp(r.x + r.dx * t - static_cast<double>(cell.x), 0.0, 1.0);
    const double v = std::clamp(r.y + r.dy * t - static_cast<double>(cell.y), 0.0, 1.0);
    return rayHeight(ray_, t) - heightIn(cell, u, v);
}

/// The vertical strip where tiles of unlike mips meet.
bool Walker::testBorder(const DrawnSquare& before, const DrawnSquare& here) {
    carried_ = 0.0;
    const double a = signedHeight(before.slot, t_, lastI_, lastJ_);
    const double b = signedHeight(here.slot, t_, i_, j_);
    if (a == 0.0 || b == 0.0 || (a > 0.0) == (b > 0.0)) return false;
    record(loadCell(cut_, here.slot, i_ >> here.mip, j_ >> here.mip), t_, a < 0.0, true);
    return true;
}

/// Walks one tile from (i_, j_, t_) until a hit or its border.
bool Walker::walkTile(const DrawnSquare& here) {
    const TileDesc& tile = cut_.tiles[here.slot];
    const int64_t tileX = tile.x >> here.mip, tileY = tile.y >> here.mip;
    int level = kTileLevels - 1;
    while (t_ <= tEnd_ && (i_ >> (here.mip + 9)) == (tileX >> 9) &&
           (j_ >> (here.mip + 9)) == (tileY >> 9)) {
        ++steps_;
        const int64_t bx = (i_ >> here.mip) >> level, by = (j_ >> here.mip) >> level;
        const Block block{bx << level, by << level, int64_t{1} << level};
        Exit exit = exitOf(block, here.mip);
        const double tOut = std::min(exit.t, tEnd_);
        if (level == 0) {
            if (testCell(here.slot, block.x, block.y, tOut)) return true;
        } else {
            const int n = kSlotCells >> level;
            const uint32_t code =
                cut_.bounds[tile.bounds + levelOffset(level) +
                            static_cast<uint32_t>((by & (n - 1)) * n + (bx & (n - 1)))];
            const uint32_t lo = code & 0xFFFFu, hi = code >> 16;
            const bool empty = lo > hi;
            const double zLo = std::fma(tile.boundsStep, static_cast<float>(lo), tile.boundsZ0);
            const double zHi = std::fma(tile.boundsStep, static_cast<float>(hi), tile.boundsZ0);
            if (!empty && !misses(t_, tOut, zLo, zHi)) {
                --level;
                continue;
            }
            carried_ = 0.0;
        }
        advance(block, here.mip, exit);
        if (level < kTileLevels - 1 && (((i_ >> here.mip) >> (level + 1)) != (bx >> 1) ||
                                        ((j_ >> here.mip) >> (level + 1)) != (by >> 1)))
            ++level;
    }
    return false;
}

bool Walker::run() {
    DrawnSquare before;
    while (t_ <= tEnd_ && i_ >= 0 && j_ >= 0 && i_ < cut_.cellsX && j_ < cut_.cellsY) {
        ++steps_;
        const DrawnSquare here = squareAt(i_, j_);
        if (!here.empty && !before.empty && before.slot != here.slot && before.mip != here.mip &&
            testBorder(before, here))
            return true;
        const int64_t x = (i_ >> (9 + here.mip)) << 9, y = (j_ >> (9 + here.mip)) << 9;
        const Block block{x, y, kSlotCells};
        const Exit exit = exitOf(block, here.mip);
        const Square& s = square(here.mip, i_, j_);
        if (here.empty || misses(t_, std::min(exit.t, tEnd_), static_cast<double>(s.minZ),
                                 static_cast<double>(s.maxZ))) {
            carried_ = 0.0;
            advance(block, here.mip, exit);
        } else if (walkTile(here)) {
            return true;
        }
        before = here;
    }
    return false;
}

Hit Walker::walk() {
    const Clip clip = clipRay(cut_, ray_);
    if (clip.begin <= clip.end) {
        t_ = clip.begin;
        tEnd_ = clip.end;
        i_ = cellAlong(ray_.x, ray_.dx, t_, 0, 0, cut_.cellsX - 1);
        j_ = cellAlong(ray_.y, ray_.dy, t_, 0, 0, cut_.cellsY - 1);
        if (!run()) hit_.flags = 0;
    }
    hit_.steps = static_cast<uint16_t>(std::min(steps_, kMaxSteps));
    return hit_;
}

/// A shadow ray from a place on the sheet: in its first cell the known root t = 0 is divided out,
/// f(t) / t = f1 + f2 t. A start on a border that leaves at once starts in the neighbour as well.
bool Walker::leavesSheet(Cell cell, double u, double v, double side) {
    for (;;) {
        Quadratic q = cellQuadratic(cell, ray_, 0.0, u, v);
        Exit exit = exitOf({cell.x, cell.y, 1}, cell.mip);
        double tCell = exit.t;
        if (cut_.surface == kSurfaceConstant) {
            q.f1 = ray_.dz;
            q.f2 = ray_.bend;
            tCell = std::min(tCell, quadrantExit(cell, u, v));
        } else if (cut_.surface == kSurfaceTriangles) {
            const CellRay r = cellRay(ray_, cell.mip);
            const bool upper = u + v > 1.0 || (u + v == 1.0 && r.dx + r.dy > 0.0);
            const double meets = (1.0 - u - v) / (r.dx + r.dy);
            q.f1 = ray_.dz - triangleSlope(cell, r, upper);
            q.f2 = ray_.bend;
            if (meets > 0.0) tCell = std::min(tCell, meets);
        }
        const double length = std::min(tCell, tEnd_);
        if (side * q.f1 < 0.0 || (q.f1 == 0.0 && side * q.f2 <= 0.0)) return true;
        const double f = side * (q.f1 + q.f2 * length);
        if (length > 0.0 && f <= 0.0) return true;
        if (length >= tEnd_) return false;
        carried_ = length > 0.0 ? side * f * length : side;
        t_ = tCell;
        if (tCell < exit.t && testRest(cell, std::min(exit.t, tEnd_))) return true;
        advance({cell.x, cell.y, 1}, cell.mip, exit);
        if (i_ < 0 || j_ < 0 || i_ >= cut_.cellsX || j_ >= cut_.cellsY) return false;
        if (length > 0.0) return run();
        const DrawnSquare here = squareAt(i_, j_);
        carried_ = 0.0;
        if (here.empty) return run();
        cell = loadCell(cut_, here.slot, i_ >> here.mip, j_ >> here.mip);
        if (!cell.valid) return run();
        const CellRay r = cellRay(ray_, cell.mip);
        u = std::clamp(r.x - static_cast<double>(cell.x), 0.0, 1.0);
        v = std::clamp(r.y - static_cast<double>(cell.y), 0.0, 1.0);
        const double height = heightIn(cell, u, v);
        if (height != ray_.z) return side * (ray_.z - height) < 0.0 || run();
    }
}

/// t just after the ray leaves the quadrant of (u, v).
double Walker::quadrantExit(const Cell& cell, double u, double v) const {
    const CellRay r = cellRay(ray_, cell.mip);
    const double tu = ((u >= 0.5) == (r.dx > 0.0)) || r.dx == 0.0 ? kHuge : (0.5 - u) / r.dx;
    const double tv = ((v >= 0.5) == (r.dy > 0.0)) || r.dy == 0.0 ? kHuge : (0.5 - v) / r.dy;
    return std::max(std::min(tu, tv), 0.0) + pastWalls(cell.mip, tu <= tv, tv < tu);
}

/// A t just past the quadrant walls on which the ray starts.
double Walker::pastWalls(int mip, bool wallX, bool wallY) const {
    const double size = std::ldexp(kNudge, mip);
    return std::max(wallX ? size / std::fabs(ray_.dx) : 0.0,
                    wallY ? size / std::fabs(ray_.dy) : 0.0);
}

/// The wall between quadrants of one cell.
bool Walker::leavesQuadrantWall(const Hit& start, const Cell& cell, bool wallX, bool wallY,
                                double side) {
    if ((wallX && !wallY && ray_.dx == 0.0) || (wallY && !wallX && ray_.dy == 0.0)) return true;
    const bool right = wallX ? ray_.dx > 0.0 : start.u >= 0.5f;
    const bool lower = wallY ? ray_.dy > 0.0 : start.v >= 0.5f;
    if (side * (ray_.z - quadrantHeight(cell, right ? 1.0 : 0.0, lower ? 1.0 : 0.0)) <= 0.0)
        return true;
    carried_ = side;
    t_ = pastWalls(cell.mip, wallX, wallY);
    i_ = cellAlong(ray_.x, ray_.dx, t_, 0, 0, cut_.cellsX - 1);
    j_ = cellAlong(ray_.y, ray_.dy, t_, 0, 0, cut_.cellsY - 1);
    return run();
}

/// A shadow ray from a wall or strip: free only on the side from which the wall was seen.
bool Walker::leavesWall(const Hit& start, const Cell& cell) {
    const auto onHalf = [this](float place) {
        return cut_.surface == kSurfaceConstant &&
               (place == 0.5f || place == std::nextafter(0.5f, 0.0f));
    };
    const auto onRim = [](float place) { return place == 0.0f || place == 1.0f; };
    const bool halfX = onHalf(start.u), halfY = onHalf(start.v);
    const double side = (start.flags & kHitFromBelow) != 0 ? -1.0 : 1.0;
    if (halfX || halfY) return leavesQuadrantWall(start, cell, halfX, halfY, side);
    if (onRim(start.u) && !onRim(start.v) && ray_.dx == 0.0) return true;
    if (onRim(start.v) && !onRim(start.u) && ray_.dy == 0.0) return true;
    const int64_t size = int64_t{1} << cell.mip;
    const auto enter = [&](float place, int64_t first, double step, int64_t& index) {
        if (place == 0.0f) index = step < 0.0 ? first * size - 1 : first * size;
        if (place == 1.0f) index = step < 0.0 ? (first + 1) * size - 1 : (first + 1) * size;
    };
    enter(start.u, cell.x, ray_.dx, i_);
    enter(start.v, cell.y, ray_.dy, j_);
    if (i_ < 0 || j_ < 0 || i_ >= cut_.cellsX || j_ >= cut_.cellsY) return false;
    const DrawnSquare here = squareAt(i_, j_);
    const double f = here.empty ? 0.0 : signedHeight(here.slot, 0.0, i_, j_);
    const bool hole =
        here.empty || !loadCell(cut_, here.slot, i_ >> here.mip, j_ >> here.mip).valid;
    return (!hole && side * f <= 0.0) || run();
}

/// True: the shadow ray that leaves `start` is stopped.
bool Walker::walkFrom(const Hit& start) {
    const TileDesc& tile = cut_.tiles[start.tile];
    const int mip = start.mip;
    const Cell cell =
        loadCell(cut_, start.tile, (tile.x >> mip) + cellX(start), (tile.y >> mip) + cellY(start));
    t_ = 0.0;
    tEnd_ = std::max(clipRay(cut_, ray_).end, 0.0);
    i_ = cellAlong(ray_.x, ray_.dx, 0.0, 0, cell.x << mip, ((cell.x + 1) << mip) - 1);
    j_ = cellAlong(ray_.y, ray_.dy, 0.0, 0, cell.y << mip, ((cell.y + 1) << mip) - 1);
    if ((start.flags & kHitStrip) != 0) return leavesWall(start, cell);
    const double side = (start.flags & kHitFromBelow) != 0 ? -1.0 : 1.0;
    return leavesSheet(cell, static_cast<double>(start.u), static_cast<double>(start.v), side);
}

}  // namespace

Hit firstHit(const TerrainCut& cut, const Ray& ray) { return Walker(cut, ray).walk(); }

bool occluded(const TerrainCut& cut, const Hit& hit, const Ray& ray) {
    return isHit(hit) && Walker(cut, ray).walkFrom(hit);
}

}  // namespace terray::exact
