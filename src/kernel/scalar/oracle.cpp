// SPDX-License-Identifier: Apache-2.0
// The oracle's loops. All lattice lengths here are in half cells of mip 0, so that the quadrants of
// the constant surface have integer borders, too (the scaling by two is exact).
#include "kernel/scalar/oracle.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace terray::oracle {
namespace {

/// A point of the ray. On the border of a patch the coordinate is the border's, exactly.
struct Place {
    double t, x, y;
};

/// A square with one bilinear surface: a cell, or a quadrant of a cell of the constant surface; or
/// with two triangles. Or a square without a surface: a hole, or an empty part of the directory.
struct Patch {
    int64_t x = 0, y = 0, size = 0;             // half cells of mip 0
    bool valid = false;                         // has a surface
    bool split = false;                         // two planes, on either side of u + v = 1
    double h00 = 0, h10 = 0, h01 = 0, h11 = 0;  // corners (x, y), (x+1, y), (x, y+1), (x+1, y+1)
    uint32_t slot = kNoSlot, mip = 0, cell = 0;
    int quadrantX = 0, quadrantY = 0;
};

/// Exact at both ends, and on level ground.
double lerp(double a, double b, double s) { return s == 1 ? b : a + (b - a) * s; }

double localX(const Patch& p, double x) {
    return std::clamp((x - static_cast<double>(p.x)) / static_cast<double>(p.size), 0.0, 1.0);
}
double localY(const Patch& p, double y) {
    return std::clamp((y - static_cast<double>(p.y)) / static_cast<double>(p.size), 0.0, 1.0);
}

/// Height of a patch. On an edge only the two posts of that edge count: both sides agree to the
/// last bit.
double heightAt(const Patch& p, const Place& place) {
    const double u = localX(p, place.x), v = localY(p, place.y);
    const bool inside = u > 0 && u < 1 && v > 0 && v < 1;
    if (p.split && inside) {
        if (u + v <= 1) return p.h00 + (p.h10 - p.h00) * u + (p.h01 - p.h00) * v;
        return p.h11 + (p.h01 - p.h11) * (1 - u) + (p.h10 - p.h11) * (1 - v);
    }
    return lerp(lerp(p.h00, p.h10, u), lerp(p.h01, p.h11, u), v);
}

/// Height at a place on the diagonal of a split patch: both of its triangles agree.
double heightOnDiagonal(const Patch& p, const Place& place) {
    return lerp(p.h10, p.h01, localY(p, place.y));
}

/// The coefficient of u v.
double twist(const Patch& p) { return p.split ? 0 : (p.h00 - p.h10) + (p.h11 - p.h01); }

/// Fills the surface of one cell (of one quadrant of it) of a tile.
Patch patchOfCell(const TerrainCut& cut, uint32_t slot, int i, int j, int quadrantX,
                  int quadrantY) {
    const TileDesc& tile = cut.tiles[slot];
    Patch p;
    p.slot = slot;
    p.mip = tile.mipFlags & kTileMipMask;
    p.cell = static_cast<uint32_t>(j * 512 + i);
    p.x = 2 * (static_cast<int64_t>(tile.x) + (static_cast<int64_t>(i) << p.mip));
    p.y = 2 * (static_cast<int64_t>(tile.y) + (static_cast<int64_t>(j) << p.mip));
    p.size = int64_t{2} << p.mip;
    p.h00 = post(cut, slot, i, j);
    p.h10 = post(cut, slot, i + 1, j);
    p.h01 = post(cut, slot, i, j + 1);
    p.h11 = post(cut, slot, i + 1, j + 1);
    p.valid = std::isfinite(p.h00) && std::isfinite(p.h10) && std::isfinite(p.h01) &&
              std::isfinite(p.h11);
    p.split = cut.surface == kSurfaceTriangles;
    if (cut.surface == kSurfaceConstant) {
        p.size /= 2;
        p.x += quadrantX * p.size;
        p.y += quadrantY * p.size;
        p.quadrantX = quadrantX;
        p.quadrantY = quadrantY;
        const double nearest =
            quadrantY == 0 ? (quadrantX == 0 ? p.h00 : p.h10) : (quadrantX == 0 ? p.h01 : p.h11);
        p.h00 = p.h10 = p.h01 = p.h11 = nearest;
    }
    return p;
}

/// The patch that holds the half cell (x, y), which lies inside the terrain's rectangle.
Patch patchAt(const TerrainCut& cut, int64_t x, int64_t y) {
    for (int d = cut.rootLevel; d >= 0; --d) {
        const DirectoryLevel& level = cut.levels[d];
        const int64_t column = x >> (10 + d), row = y >> (10 + d);
        const Square& square = cut.squares[level.offset + row * level.columns + column];
        if (square.state == kSquareDescend) continue;
        if (square.state == kSquareDrawn) {
            const TileDesc& tile = cut.tiles[square.slot];
            const uint32_t mip = tile.mipFlags & kTileMipMask;
            const int64_t tileX = x - 2 * int64_t{tile.x}, tileY = y - 2 * int64_t{tile.y};
            return patchOfCell(cut, square.slot, static_cast<int>(tileX >> (mip + 1)),
                               static_cast<int>(tileY >> (mip + 1)),
                               static_cast<int>(tileX >> mip) & 1,
                               static_cast<int>(tileY >> mip) & 1);
        }
        Patch nothing;
        nothing.size = int64_t{1024} << d;
        nothing.x = column * nothing.size;
        nothing.y = row * nothing.size;
        return nothing;
    }
    Patch nothing;
    nothing.size = 2;
    nothing.x = x & ~int64_t{1};
    nothing.y = y & ~int64_t{1};
    return nothing;
}

/// First zero, 0..1, of the quadratic with f(0) = f0, f(1) = f1 and a s^2 as its highest term. A
/// change of sign between the ends is never missed.
std::optional<double> firstZero(double f0, double f1, double a) {
    if (f0 == 0) return 0.0;
    if (f0 < 0) {  // mirrored: from above
        f0 = -f0;
        f1 = -f1;
        a = -a;
    }
    const double b = f1 - f0 - a;
    double discriminant = 0;
    if (f1 > 0) {  // both ends above: it dips to zero if a >= (sqrt f0 + sqrt f1)^2
        const double mean = 2 * std::sqrt(f0) * std::sqrt(f1);
        if (!(a >= f0 + f1 + mean)) return std::nullopt;
        discriminant = (a - (f0 + f1 - mean)) * (a - (f0 + f1 + mean));
    } else if (a > 0) {
        discriminant = (a - f0) * (a - f0) + f1 * f1 - 2 * f1 * (a + f0);
    } else {
        discriminant = b * b - 4 * a * f0;
    }
    // The zero at which f falls, in the form that does not cancel.
    const double root = std::sqrt(std::max(discriminant, 0.0));
    const double s = b <= 0 ? 2 * f0 / (root - b) : (b + root) / (-2 * a);
    return std::clamp(s, 0.0, 1.0);
}

/// What is known at the border of the patch being left: f = ray height - surface; zero: nothing.
struct Before {
    double f = 0, height = NAN;
};

/// One ray on its way through the patches.
class Walk {
public:
    Walk(const TerrainCut& cut, const Ray& ray, const BlockRanges* ranges)
        : cut_(cut), ranges_(ranges), ray_(ray) {
        ray_.x *= 2;
        ray_.y *= 2;
        ray_.dx *= 2;
        ray_.dy *= 2;
    }

    bool clip();
    ExactHit follow(Patch patch, Place in, Before before);
    ExactHit followFromStart() { return follow(patchAt(cut_, start_.x, start_.y), start_, {}); }
    bool occludedOnSheet(Patch patch, bool fromBelow);
    bool occludedOnWall(const Hit& hit, const Patch& patch);

private:
    struct Exit {
        Place place;
        bool crossX, crossY, last;
    };

    static Patch patchAt(const TerrainCut& cut, double x, double y) {
        const auto column = static_cast<int64_t>(std::floor(x));
        const auto row = static_cast<int64_t>(std::floor(y));
        return oracle::patchAt(cut, std::clamp(column, int64_t{0}, 2 * int64_t{cut.cellsX} - 1),
                               std::clamp(row, int64_t{0}, 2 * int64_t{cut.cellsY} - 1));
    }
    double heightOfRay(double t) const { return ray_.z + (ray_.dz + ray_.bend * t) * t; }
    Exit exitOf(const Patch& patch, const Place& in) const;
    std::optional<Patch> nextPatch(const Patch& patch, const Exit& exit) const;
    ExactHit hitAt(const Patch& patch, double t, double u, double v, int flags) const;
    std::optional<Place> diagonalPlace(const Patch& patch, const Place& in, const Place& out) const;
    std::optional<ExactHit> cross(const Patch& patch, const Place& in, const Place& out, double h0,
                                  double h1, Before& before) const;
    std::optional<ExactHit> crossPatch(const Patch& patch, const Place& in, const Place& out,
                                       Before& before) const;
    std::optional<Exit> passBlock(const Patch& patch, const Place& in, Patch& block,
                                  Before& before) const;

    const TerrainCut& cut_;
    const BlockRanges* ranges_;
    Ray ray_;  // half cells
    Place start_{}, end_{};
    uint32_t steps_ = 0;
};

/// Clips to the rectangle and to [tMin, tMax]; false if nothing is left.
bool Walk::clip() {
    const double far = 1e30;
    double from = ray_.tMin, to = std::min(ray_.tMax, far);
    double fromX = NAN, fromY = NAN, toX = NAN, toY = NAN;  // borders that clip
    const auto clipAxis = [&](double o, double d, double size, double& nearBorder,
                              double& farBorder, double& otherNear, double& otherFar) {
        if (d == 0) return o >= 0 && o <= size;
        const double enter = ((d > 0 ? 0 : size) - o) / d, leave = ((d > 0 ? size : 0) - o) / d;
        if (enter > from) otherNear = NAN;
        if (enter >= from) {
            from = enter;
            nearBorder = d > 0 ? 0 : size;
        }
        if (leave < to) otherFar = NAN;
        if (leave <= to) {
            to = leave;
            farBorder = d > 0 ? size : 0;
        }
        return true;
    };
    const double sizeX = 2.0 * cut_.cellsX, sizeY = 2.0 * cut_.cellsY;
    if (!clipAxis(ray_.x, ray_.dx, sizeX, fromX, toX, fromY, toY)) return false;
    if (!clipAxis(ray_.y, ray_.dy, sizeY, fromY, toY, fromX, toX)) return false;
    if (!(from <= to)) return false;
    const auto place = [&](double t, double x, double y) {
        x = std::isnan(x) ? ray_.x + ray_.dx * t : x;
        y = std::isnan(y) ? ray_.y + ray_.dy * t : y;
        return Place{t, std::clamp(x, 0.0, sizeX), std::clamp(y, 0.0, sizeY)};
    };
    start_ = place(from, fromX, fromY);
    end_ = place(to, toX, toY);
    return true;
}

Walk::Exit Walk::exitOf(const Patch& patch, const Place& in) const {
    const auto x0 = static_cast<double>(patch.x), y0 = static_cast<double>(patch.y);
    const auto size = static_cast<double>(patch.size);
    const double borderX = ray_.dx > 0 ? x0 + size : x0, borderY = ray_.dy > 0 ? y0 + size : y0;
    const double tX = ray_.dx != 0 ? (borderX - ray_.x) / ray_.dx : INFINITY;
    const double tY = ray_.dy != 0 ? (borderY - ray_.y) / ray_.dy : INFINITY;
    const double t = std::max(std::min(tX, tY), in.t);
    if (t >= end_.t) return {end_, false, false, true};
    Exit exit{{t, 0, 0}, tX <= t, tY <= t, false};
    exit.place.x = exit.crossX ? borderX : std::clamp(ray_.x + ray_.dx * t, x0, x0 + size);
    exit.place.y = exit.crossY ? borderY : std::clamp(ray_.y + ray_.dy * t, y0, y0 + size);
    return exit;
}

/// The patch behind an exit; none outside the rectangle.
std::optional<Patch> Walk::nextPatch(const Patch& patch, const Exit& exit) const {
    const auto next = [&](bool cross, double d, double place, int64_t first) {
        if (cross) return d > 0 ? first + patch.size : first - 1;
        return std::clamp(static_cast<int64_t>(std::floor(place)), first, first + patch.size - 1);
    };
    const int64_t x = next(exit.crossX, ray_.dx, exit.place.x, patch.x);
    const int64_t y = next(exit.crossY, ray_.dy, exit.place.y, patch.y);
    if (x < 0 || y < 0 || x >= 2 * int64_t{cut_.cellsX} || y >= 2 * int64_t{cut_.cellsY})
        return std::nullopt;
    return oracle::patchAt(cut_, x, y);
}

ExactHit Walk::hitAt(const Patch& patch, double t, double u, double v, int flags) const {
    ExactHit exact;
    exact.t = t;
    Hit& hit = exact.hit;
    hit.t = static_cast<float>(t);
    hit.tile = patch.slot;
    hit.cell = patch.cell;
    hit.mip = static_cast<uint8_t>(patch.mip);
    hit.steps = static_cast<uint16_t>(std::min(steps_, 65535u));
    hit.flags = static_cast<uint8_t>(kHitValid | flags);
    hit.u = static_cast<float>(u);
    hit.v = static_cast<float>(v);
    if (cut_.surface == kSurfaceConstant) {
        const float belowHalf = std::nextafter(0.5f, 0.0f);
        hit.u = static_cast<float>((patch.quadrantX + u) / 2);
        hit.v = static_cast<float>((patch.quadrantY + v) / 2);
        if (patch.quadrantX == 0) hit.u = std::min(hit.u, belowHalf);
        if (patch.quadrantY == 0) hit.v = std::min(hit.v, belowHalf);
    }
    return exact;
}

/// Where a ray crosses the diagonal of a split patch on its way from `in` to `out`, if inside.
std::optional<Place> Walk::diagonalPlace(const Patch& patch, const Place& in,
                                         const Place& out) const {
    if (!patch.split) return std::nullopt;
    const double before = localX(patch, in.x) + localY(patch, in.y) - 1;
    const double after = localX(patch, out.x) + localY(patch, out.y) - 1;
    if (!((before < 0 && after > 0) || (before > 0 && after < 0))) return std::nullopt;
    const double s = before / (before - after);
    return Place{lerp(in.t, out.t, s), lerp(in.x, out.x, s), lerp(in.y, out.y, s)};
}

/// From `in` to `out` within a patch, where the surface along the ray is one quadratic with the
/// heights h0 and h1 at its ends.
std::optional<ExactHit> Walk::cross(const Patch& patch, const Place& in, const Place& out,
                                    double h0, double h1, Before& before) const {
    const double u0 = localX(patch, in.x), u1 = localX(patch, out.x);
    const double v0 = localY(patch, in.y), v1 = localY(patch, out.y);
    double f0 = heightOfRay(in.t) - h0;
    const double f1 = heightOfRay(out.t) - h1;
    if (before.height == h0) f0 = before.f;
    if (f0 != 0 && before.f != 0 && (f0 < 0) != (before.f < 0))
        return hitAt(patch, in.t, u0, v0, kHitStrip | (before.f < 0 ? kHitFromBelow : 0));
    const double length = out.t - in.t;
    const double a = ray_.bend * length * length - twist(patch) * (u1 - u0) * (v1 - v0);
    if (const auto s = firstZero(f0, f1, a)) {
        const bool fromBelow = (f0 != 0 ? f0 : before.f) < 0;
        return hitAt(patch, in.t + *s * length, lerp(u0, u1, *s), lerp(v0, v1, *s),
                     fromBelow ? kHitFromBelow : 0);
    }
    before = Before{f1, h1};
    return std::nullopt;
}

/// The whole way through a patch that has a surface: in one part or, over a diagonal, in two.
std::optional<ExactHit> Walk::crossPatch(const Patch& patch, const Place& in, const Place& out,
                                         Before& before) const {
    const double h0 = heightAt(patch, in), h1 = heightAt(patch, out);
    const auto middle = diagonalPlace(patch, in, out);
    if (!middle) return cross(patch, in, out, h0, h1, before);
    const double height = heightOnDiagonal(patch, *middle);
    if (const auto hit = cross(patch, in, *middle, h0, height, before)) return hit;
    return cross(patch, *middle, out, height, h1, before);
}

/// The way through the largest block of cells around `patch` that the ray clears, on the side on
/// which it came.
std::optional<Walk::Exit> Walk::passBlock(const Patch& patch, const Place& in, Patch& block,
                                          Before& before) const {
    const TileDesc& tile = cut_.tiles[patch.slot];
    const auto i = static_cast<int>(patch.cell & 511u), j = static_cast<int>(patch.cell >> 9);
    for (int level = 0; level < BlockRanges::kLevels; ++level) {
        const int shift = BlockRanges::kShift[level];
        block.size = int64_t{2} << (shift + static_cast<int>(patch.mip));
        block.x = 2 * int64_t{tile.x} + (i >> shift) * block.size;
        block.y = 2 * int64_t{tile.y} + (j >> shift) * block.size;
        const Exit exit = exitOf(block, in);
        const int side = sideOf(ranges_->at(patch.slot, level, i, j), ray_, in.t, exit.place.t);
        if (side == 0 || before.f * side < 0) continue;
        before = Before{static_cast<double>(side), NAN};
        return exit;
    }
    return std::nullopt;
}

/// Walks from `in`, on the border of or inside `patch`, to the first hit.
ExactHit Walk::follow(Patch patch, Place in, Before before) {
    for (;;) {
        ++steps_;
        Patch block;
        if (ranges_ != nullptr && patch.valid) {
            if (const auto exit = passBlock(patch, in, block, before)) {
                const auto next = exit->last ? std::nullopt : nextPatch(block, *exit);
                if (!next) return {};
                patch = *next;
                in = exit->place;
                continue;
            }
        }
        const Exit exit = exitOf(patch, in);
        const Place& out = exit.place;
        if (patch.valid) {
            if (const auto hit = crossPatch(patch, in, out, before)) return *hit;
        } else {
            before = Before{};
        }
        if (exit.last) return {};
        const auto next = nextPatch(patch, exit);
        if (!next) return {};
        patch = *next;
        in = out;
    }
}

/// From a place on the sheet: f(s) = s (f1 + f2 s) in the first patch, the known zero divided out.
/// A start on the border that leaves at once starts in the neighbour as well.
bool Walk::occludedOnSheet(Patch patch, bool fromBelow) {
    const auto x0 = static_cast<double>(patch.x), y0 = static_cast<double>(patch.y);
    const auto size = static_cast<double>(patch.size);
    const double side = fromBelow ? -1 : 1;
    ray_.x = std::clamp(ray_.x, x0, x0 + size);
    ray_.y = std::clamp(ray_.y, y0, y0 + size);
    const Place start{0, ray_.x, ray_.y};
    ray_.z = heightAt(patch, start);
    ray_.tMin = 0;
    if (!clip()) return false;
    for (;;) {
        const double u = localX(patch, start.x), v = localY(patch, start.y);
        const double du = ray_.dx / static_cast<double>(patch.size);
        const double dv = ray_.dy / static_cast<double>(patch.size);
        // A split patch has the slopes of an edge of the triangle that the ray starts into.
        const bool upper = u + v > 1 || (u + v == 1 && du + dv > 0);
        const double edgeV = patch.split ? (upper ? 1 : 0) : v;
        const double edgeU = patch.split ? (upper ? 1 : 0) : u;
        const double rise = lerp(patch.h10 - patch.h00, patch.h11 - patch.h01, edgeV) * du +
                            lerp(patch.h01 - patch.h00, patch.h11 - patch.h10, edgeU) * dv;
        const double f1 = side * (ray_.dz - rise);
        const double f2 = side * (ray_.bend - twist(patch) * du * dv);
        if (f1 < 0 || (f1 == 0 && f2 <= 0)) return true;
        const Exit exit = exitOf(patch, start);
        const auto middle = diagonalPlace(patch, start, exit.place);
        const double length = middle ? middle->t : exit.place.t;
        double f = length * (f1 + f2 * length);
        if (length > 0 && f <= 0) return true;
        if (middle) {
            Before before{side * f, heightOnDiagonal(patch, *middle)};
            if (cross(patch, *middle, exit.place, before.height, heightAt(patch, exit.place),
                      before))
                return true;
            f = side * before.f;
        }
        if (exit.last) return false;
        const auto next = nextPatch(patch, exit);
        if (!next) return false;
        if (length > 0)
            return isHit(
                follow(*next, exit.place, Before{side * f, heightAt(patch, exit.place)}).hit);
        if (!next->valid) return isHit(follow(*next, start, {}).hit);
        const double nextHeight = heightAt(*next, start);
        if (nextHeight != ray_.z)  // over the edge of a strip, or into it
            return side * (ray_.z - nextHeight) < 0 || isHit(follow(*next, start, {}).hit);
        patch = *next;
    }
}

/// From a place on a vertical strip or wall: `patch` is the one that was being entered. Free only
/// on the side from which the wall was seen.
bool Walk::occludedOnWall(const Hit& hit, const Patch& patch) {
    const bool fromBelow = (hit.flags & kHitFromBelow) != 0;
    // Place on the border of the patch, 0 or 1 in its own coordinates; else inside.
    const auto onBorder = [&](float place, int quadrant) -> std::optional<int> {
        const bool constant = cut_.surface == kSurfaceConstant;
        const float first = constant && quadrant == 1 ? 0.5f : 0.0f;
        const float last = constant && quadrant == 0 ? std::nextafter(0.5f, 0.0f) : 1.0f;
        if (place == first) return 0;
        return place == last ? std::optional(1) : std::nullopt;
    };
    const auto wallX = onBorder(hit.u, patch.quadrantX), wallY = onBorder(hit.v, patch.quadrantY);
    if (wallX && !wallY && ray_.dx == 0) return true;
    if (wallY && !wallX && ray_.dy == 0) return true;
    const auto halfCell = [](std::optional<int> wall, int64_t first, int64_t size, double d,
                             double& place) {
        const auto low = static_cast<double>(first), high = static_cast<double>(first + size);
        if (!wall) {
            place = std::clamp(place, low, high);
            return std::clamp(static_cast<int64_t>(std::floor(place)), first, first + size - 1);
        }
        const int64_t border = first + *wall * size;
        place = static_cast<double>(border);
        return d < 0 ? border - 1 : border;
    };
    const int64_t x = halfCell(wallX, patch.x, patch.size, ray_.dx, ray_.x);
    const int64_t y = halfCell(wallY, patch.y, patch.size, ray_.dy, ray_.y);
    ray_.tMin = 0;
    if (x < 0 || y < 0 || x >= 2 * int64_t{cut_.cellsX} || y >= 2 * int64_t{cut_.cellsY} || !clip())
        return false;
    const Place start{0, ray_.x, ray_.y};
    const Patch first = oracle::patchAt(cut_, x, y);
    if (!first.valid) return isHit(follow(first, start, {}).hit);
    const double f = ray_.z - heightAt(first, start);
    return f == 0 || (f < 0) != fromBelow || isHit(follow(first, start, {}).hit);
}

}  // namespace

double post(const TerrainCut& cut, uint32_t slot, int i, int j) {
    const TileDesc& tile = cut.tiles[slot];
    const uint64_t index =
        tile.posts + static_cast<uint64_t>(j) * kPostStride + static_cast<uint64_t>(i);
    if (cut.format == 1) return static_cast<double>(static_cast<const float*>(cut.posts)[index]);
    const uint16_t code = static_cast<const uint16_t*>(cut.posts)[index];
    if (code == 0xFFFF) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(std::fma(tile.zStep, static_cast<float>(code), tile.z0));
}

ExactHit firstHit(const TerrainCut& cut, const Ray& ray, const BlockRanges* ranges) {
    Walk walk(cut, ray, ranges);
    if (!walk.clip()) return {};
    return walk.followFromStart();
}

bool occluded(const TerrainCut& cut, const Hit& hit, const Ray& ray, const BlockRanges* ranges) {
    if (!isHit(hit)) return false;
    const Patch patch =
        patchOfCell(cut, hit.tile, static_cast<int>(cellX(hit)), static_cast<int>(cellY(hit)),
                    hit.u >= 0.5f ? 1 : 0, hit.v >= 0.5f ? 1 : 0);
    Walk walk(cut, ray, ranges);
    if ((hit.flags & kHitStrip) != 0) return walk.occludedOnWall(hit, patch);
    return walk.occludedOnSheet(patch, (hit.flags & kHitFromBelow) != 0);
}

}  // namespace terray::oracle
