// SPDX-License-Identifier: Apache-2.0
// Down the tree of tiles, through boxes that are widened for rounding.
#include "stream/ray_tiles.h"

#include <algorithm>
#include <cmath>

#include "stream/pool.h"
#include "stream/tile_rule.h"

namespace terray {
namespace {

constexpr double kWiden = 1e-3;  ///< cells of mip 0, on each side

struct Span {
    double begin, end;
    bool isEmpty() const { return !(begin <= end); }
};

/// Where from + t * by lies between low and high.
Span clip(Span span, double from, double by, double low, double high) {
    if (by == 0) return from >= low && from <= high ? span : Span{1, 0};
    const double a = (low - from) / by, b = (high - from) / by;
    return {std::max(span.begin, std::min(a, b)), std::min(span.end, std::max(a, b))};
}

/// Heights of mip 0 in a tile, from its blocks; low > high if there is none.
Span heightsOf(std::span<const BlockBounds> blocks, SurfaceKind surface) {
    Span heights{HUGE_VAL, -HUGE_VAL};
    for (const BlockBounds& block : blocks) {
        const bool isHole = block.minZ > block.maxZ;
        // Where coverage differs mip 0 may stand where the tile's own mip has no cell.
        if (isHole && (block.flags & kBlockFinestHasCells) != 0) return {-HUGE_VAL, HUGE_VAL};
        if (isHole) continue;
        double error = static_cast<double>(block.errorToFinest);
        if (surface != kSurfaceBilinear) error += 2 * static_cast<double>(block.cellRange);
        if (block.coverageError > 0) error = HUGE_VAL;
        heights.begin = std::min(heights.begin, static_cast<double>(block.minZ) - error);
        heights.end = std::max(heights.end, static_cast<double>(block.maxZ) + error);
    }
    return heights;
}

/// Heights of a bent ray over a stretch of it: it sags, so it is highest at an end.
Span heightsOf(const Ray& ray, Span span) {
    const auto at = [&](double t) { return ray.z + t * (ray.dz + ray.bend * t); };
    double low = std::min(at(span.begin), at(span.end));
    const double lowest = ray.bend > 0 ? -ray.dz / (2 * ray.bend) : span.begin;
    if (lowest > span.begin && lowest < span.end) low = at(lowest);
    return {low, std::max(at(span.begin), at(span.end))};
}

class Walk {
public:
    Walk(const ResidentTerrain& terrain, const Ray& ray, SurfaceKind surface)
        : pool_(terrain.pool()), ray_(ray), surface_(surface) {}

    void visit(TileId id, Span span) {
        const double size = std::ldexp(kTileCells, id.mip);
        span = clip(span, ray_.x, ray_.dx, id.x * size - kWiden, (id.x + 1) * size + kWiden);
        span = clip(span, ray_.y, ray_.dy, id.y * size - kWiden, (id.y + 1) * size + kWiden);
        if (span.isEmpty()) return;
        const uint32_t number = pool_.numberOf(id);
        const Span ground = heightsOf(pool_.blocksOf(number), surface_);
        const Span seen = heightsOf(ray_, span);
        const double slack = 1e-3 + 1e-6 * std::max(std::fabs(seen.begin), std::fabs(seen.end));
        if (!(seen.begin - slack <= ground.end && seen.end + slack >= ground.begin)) return;
        if (id.mip == 0) {
            if (!pool_.isHollow(number)) found.push_back({id, span.begin});
            return;
        }
        uint32_t children[4];
        const int count = childrenOf(pool_, id, children);
        for (int k = 0; k < count; ++k) visit(pool_.tileOf(children[k]), span);
    }

    std::vector<RayTile> found;

private:
    const ResidentTerrain::Pool& pool_;
    const Ray& ray_;
    SurfaceKind surface_;
};

}  // namespace

std::vector<RayTile> tilesAlong(const ResidentTerrain& terrain, const Ray& ray,
                                SurfaceKind surface) {
    Walk walk(terrain, ray, surface);
    walk.visit({terrain.mipCount() - 1, 0, 0}, {ray.tMin, ray.tMax});
    std::stable_sort(walk.found.begin(), walk.found.end(),
                     [](const RayTile& a, const RayTile& b) { return a.enter < b.enter; });
    return std::move(walk.found);
}

}  // namespace terray
