// SPDX-License-Identifier: Apache-2.0
// The rules by which kernels are judged.
#include "kernel/scalar/judge.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

namespace terray::oracle {
namespace {

/// Distance, in cells of mip 0, of a place from the closed cell that a hit names.
double distanceFromCell(const TerrainCut& cut, const Hit& hit, double x, double y) {
    const TileDesc& tile = cut.tiles[hit.tile];
    const double size = std::ldexp(1.0, hit.mip);
    const double left = tile.x + cellX(hit) * size, top = tile.y + cellY(hit) * size;
    const double outsideX = std::max({left - x, x - (left + size), 0.0});
    const double outsideY = std::max({top - y, y - (top + size), 0.0});
    return std::max(outsideX, outsideY);
}

/// |df/dt| at the oracle's hit.
double approachSpeed(const TerrainCut& cut, const Ray& ray, const ExactHit& exact) {
    const Hit& hit = exact.hit;
    const int i = static_cast<int>(cellX(hit)), j = static_cast<int>(cellY(hit));
    const double h00 = post(cut, hit.tile, i, j), h10 = post(cut, hit.tile, i + 1, j);
    const double h01 = post(cut, hit.tile, i, j + 1), h11 = post(cut, hit.tile, i + 1, j + 1);
    const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
    const double size = std::ldexp(1.0, hit.mip);
    double rise = ((h10 - h00) * (1 - v) + (h11 - h01) * v) / size * ray.dx +
                  ((h01 - h00) * (1 - u) + (h11 - h10) * u) / size * ray.dy;
    if (cut.surface == kSurfaceTriangles)
        rise = u + v <= 1 ? ((h10 - h00) * ray.dx + (h01 - h00) * ray.dy) / size
                          : ((h11 - h01) * ray.dx + (h11 - h10) * ray.dy) / size;
    if (cut.surface == kSurfaceConstant) rise = 0;
    return std::abs(ray.dz + 2 * ray.bend * exact.t - rise);
}

/// How far aside a place still counts as the same: 1e-9 of it, and the rounding of the place.
double slackAt(const Ray& ray, double t) {
    return 1e-9 * std::max({1.0, std::abs(ray.x + ray.dx * t), std::abs(ray.y + ray.dy * t)}) +
           0x1p-49 * (std::abs(ray.x) + std::abs(ray.y) + std::hypot(ray.dx, ray.dy) * t);
}

/// True if `fits` holds for one of the eight rays around a ray.
template <class Fits>
bool fitsAside(const Ray& ray, double slack, const Fits& fits) {
    for (int k = 0; k < 9; ++k) {
        Ray aside = ray;
        aside.x += (k % 3 - 1) * slack;
        aside.y += (k / 3 - 1) * slack;
        if (k != 4 && fits(aside)) return true;
    }
    return false;
}

Fault judgeStrictly(const TerrainCut& cut, const Ray& ray, const Hit& hit, const ExactHit& exact) {
    if (isHit(hit) != isHit(exact.hit)) return Fault::HitMiss;
    if (!isHit(hit)) return Fault::None;
    if (hit.tile >= cut.tileCount || hit.cell >= 512u * 512u) return Fault::Cell;
    const double x = ray.x + ray.dx * exact.t, y = ray.y + ray.dy * exact.t;
    const double edge = slackAt(ray, exact.t);
    const bool sameCell = hit.tile == exact.hit.tile && hit.cell == exact.hit.cell;
    if (!sameCell && distanceFromCell(cut, hit, x, y) > edge) return Fault::Cell;
    const double eps =
        0x1p-23 * static_cast<double>(std::max(std::abs(cut.minZ), std::abs(cut.maxZ)));
    const double speed = std::max(approachSpeed(cut, ray, exact), 1e-300);
    const bool strip = (exact.hit.flags & kHitStrip) != 0;
    const double allowed = std::max({1e-3, 1e-5 * exact.t, strip ? 0.0 : 2 * eps / speed});
    const double dt = std::abs(static_cast<double>(hit.t) - exact.t);
    if (!(dt <= allowed)) return Fault::Distance;
    const double size = std::ldexp(1.0, hit.mip);
    const double placeX = cut.tiles[hit.tile].x + (cellX(hit) + static_cast<double>(hit.u)) * size;
    const double placeY = cut.tiles[hit.tile].y + (cellY(hit) + static_cast<double>(hit.v)) * size;
    // As far aside as along the ray: a ray along an axis has no error in t that could tell.
    const double reach = 1e-6 * size + edge + std::hypot(ray.dx, ray.dy) * allowed;
    if (hit.mip != (cut.tiles[hit.tile].mipFlags & kTileMipMask) ||
        !(std::abs(placeX - x) <= reach) || !(std::abs(placeY - y) <= reach))
        return Fault::Place;
    constexpr int kJudged = kHitFromBelow | kHitStrip;
    if (sameCell && exact.t > ray.tMin && ((hit.flags ^ exact.hit.flags) & kJudged) != 0)
        return Fault::Flags;
    return Fault::None;
}

}  // namespace

Fault judge(const TerrainCut& cut, const Ray& ray, const Hit& hit, const ExactHit& exact) {
    const Fault fault = judgeStrictly(cut, ray, hit, exact);
    if (fault == Fault::None) return fault;
    const double t = isHit(exact.hit) ? exact.t : static_cast<double>(hit.t);
    const bool tie = fitsAside(ray, slackAt(ray, t), [&](const Ray& aside) {
        return judgeStrictly(cut, aside, hit, firstHit(cut, aside)) == Fault::None;
    });
    return tie ? Fault::Tie : fault;
}

Fault judgeShadow(const TerrainCut& cut, const Hit& hit, const Ray& ray, bool answer) {
    if (occluded(cut, hit, ray) == answer) return Fault::None;
    const bool tie = fitsAside(ray, slackAt(ray, 0), [&](const Ray& aside) {
        return occluded(cut, hit, aside) == answer;
    });
    return tie ? Fault::Tie : Fault::HitMiss;
}

std::string describe(Fault fault, const Ray& ray, const Hit& hit, const ExactHit& exact) {
    constexpr const char* kNames[] = {"none",     "tie",   "hit/miss", "cell",
                                      "distance", "place", "flags"};
    char line[512];
    std::snprintf(
        line, std::size(line),
        "%s: kernel {%s t %.9g tile %u cell %u u %.9g v %.9g flags %d}, oracle {%s t %.17g "
        "tile %u cell %u u %.9g v %.9g flags %d}, ray {%.17g, %.17g, %.17g, %.17g, %.17g, "
        "%.17g, %.17g, %.17g, %.17g}",
        kNames[static_cast<int>(fault)], isHit(hit) ? "hit" : "miss", static_cast<double>(hit.t),
        hit.tile, hit.cell, static_cast<double>(hit.u), static_cast<double>(hit.v), hit.flags,
        isHit(exact.hit) ? "hit" : "miss", exact.t, exact.hit.tile, exact.hit.cell,
        static_cast<double>(exact.hit.u), static_cast<double>(exact.hit.v), exact.hit.flags, ray.x,
        ray.y, ray.z, ray.dx, ray.dy, ray.dz, ray.bend, ray.tMin, ray.tMax);
    return line;
}

}  // namespace terray::oracle
