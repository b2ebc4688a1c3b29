// SPDX-License-Identifier: Apache-2.0
// Walks a ray over the cells near rims; a wall stands where it comes from no ground to ground.
#include "shade/plinth.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/height.h"

namespace terray {
namespace {

/// Depth of the plinth under the lowest ground: a share of the terrain's larger side.
constexpr double kThickness = 0.03;
constexpr int64_t kBlock = 16;  ///< cells a side

glm::vec3 acrossOf(const Vec2& along) {
    const Vec2 n = glm::normalize(Vec2{along.y, -along.x});
    return {static_cast<float>(n.x), static_cast<float>(n.y), 0.0f};
}

/// Calls visit(i, j, tIn, tOut, enteredAcrossI) for each square of `size` cells along a ray, in
/// order, until it returns true.
template <class Visit>
void walkSquares(const Ray& ray, double size, double tIn, double tOut, const Visit& visit) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    // A hair beyond the start, so that a ray that starts on a border is in the square ahead.
    const double start = tIn + 1e-9 * (tOut - tIn);
    int64_t i = static_cast<int64_t>(std::floor((ray.x + ray.dx * start) / size));
    int64_t j = static_cast<int64_t>(std::floor((ray.y + ray.dy * start) / size));
    const int64_t stepI = ray.dx < 0 ? -1 : 1, stepJ = ray.dy < 0 ? -1 : 1;
    const auto crossing = [&](int64_t square, int64_t step, double from, double speed) {
        if (speed == 0) return kNever;
        return (static_cast<double>(square + (step > 0 ? 1 : 0)) * size - from) / speed;
    };
    bool acrossI = true;
    for (double t = tIn; t < tOut;) {
        const double nextI = crossing(i, stepI, ray.x, ray.dx);
        const double nextJ = crossing(j, stepJ, ray.y, ray.dy);
        const double next = std::min(nextI, nextJ);
        if (visit(i, j, t, std::min(next, tOut), acrossI)) return;
        acrossI = nextI <= nextJ;
        (acrossI ? i : j) += acrossI ? stepI : stepJ;
        t = std::max(next, t);
        if (next == kNever) return;
    }
}

double heightOn(const Ray& ray, double t) { return ray.z + (ray.dz + ray.bend * t) * t; }

}  // namespace

Plinth::Plinth(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays)
    : cut_(cut),
      cellsI_(info.scheme.columns - 1),
      cellsJ_(info.scheme.rows - 1),
      acrossI_(acrossOf(info.worldFromLattice.row)),
      acrossJ_(acrossOf(info.worldFromLattice.column)),
      blocksI_((cellsI_ + kBlock - 1) / kBlock),
      blocksJ_((cellsJ_ + kBlock - 1) / kBlock),
      hasRim_(static_cast<size_t>(blocksI_ * blocksJ_), 0) {
    const double side =
        std::max(static_cast<double>(cellsI_) * info.worldFromLattice.columnLength(),
                 static_cast<double>(cellsJ_) * info.worldFromLattice.rowLength());
    baseZ_ = static_cast<double>(info.minZ) - kThickness * side / rays.exaggeration();
    oneapi::tbb::parallel_for(int64_t{0}, blocksJ_, [&](int64_t row) {
        for (int64_t column = 0; column < blocksI_; ++column) {
            // One cell more on every side: walls on the block's border belong to it, too.
            size_t ground = 0, all = 0;
            for (int64_t j = row * kBlock - 1; j <= (row + 1) * kBlock; ++j)
                for (int64_t i = column * kBlock - 1; i <= (column + 1) * kBlock; ++i)
                    ground += isGround(i, j), ++all;
            hasRim_[static_cast<size_t>(row * blocksI_ + column)] = ground > 0 && ground < all;
        }
    });
}

bool Plinth::isGround(int64_t i, int64_t j) const {
    if (i < 0 || j < 0 || i >= cellsI_ || j >= cellsJ_) return false;
    return surfaceCellAt(cut_, static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5).slot !=
           kNoSlot;
}

std::optional<Plinth::WallHit> Plinth::wallAt(const Ray& ray, double t, bool acrossI) const {
    const double z = heightOn(ray, t);
    if (z < baseZ_) return std::nullopt;
    // The ground's height just inside the wall.
    const double length = std::hypot(ray.dx, ray.dy);
    const double inside = t + 1e-3 / std::max(length, 1e-12);
    const SurfaceCell rim =
        surfaceCellAt(cut_, std::clamp(ray.x + ray.dx * inside, 0.0, static_cast<double>(cellsI_)),
                      std::clamp(ray.y + ray.dy * inside, 0.0, static_cast<double>(cellsJ_)));
    if (rim.slot == kNoSlot || z > rim.height(cut_.constantSurface != 0)) return std::nullopt;
    return WallHit{static_cast<float>(t), acrossI ? acrossI_ : acrossJ_};
}

std::optional<Plinth::WallHit> Plinth::wallInBlock(const Ray& ray, double tIn, double tOut) const {
    std::optional<WallHit> found;
    // From just before the block, so that a wall on its border is crossed and not started on.
    const double before = 1e-3 / std::max(std::hypot(ray.dx, ray.dy), 1e-12);
    bool wasGround = true;
    bool first = true;
    walkSquares(ray, 1.0, tIn - before, tOut,
                [&](int64_t i, int64_t j, double t, double, bool acrossI) {
                    const bool ground = isGround(i, j);
                    if (!first && ground && !wasGround) found = wallAt(ray, t, acrossI);
                    first = false;
                    wasGround = ground;
                    return found.has_value();
                });
    return found;
}

std::optional<Plinth::WallHit> Plinth::firstWall(const Ray& ray, double tMax) const {
    double tIn = 0, tOut = tMax;
    const auto clip = [&](double from, double speed, double last) {
        if (speed == 0) {
            if (from < 0 || from > last) tOut = -1;
            return;
        }
        const double a = (0 - from) / speed, b = (last - from) / speed;
        tIn = std::max(tIn, std::min(a, b));
        tOut = std::min(tOut, std::max(a, b));
    };
    clip(ray.x, ray.dx, static_cast<double>(cellsI_));
    clip(ray.y, ray.dy, static_cast<double>(cellsJ_));
    std::optional<WallHit> found;
    // Nothing stands above the highest ground; bent rays come down later than straight ones.
    const auto highest = static_cast<double>(cut_.maxZ);
    if (ray.dz < 0) tIn = std::max(tIn, (highest - ray.z) / ray.dz);
    if (!(tIn < tOut)) return found;
    walkSquares(ray, static_cast<double>(kBlock), tIn, tOut,
                [&](int64_t i, int64_t j, double t, double tEnd, bool) {
                    const double z0 = heightOn(ray, t), z1 = heightOn(ray, tEnd);
                    const double sag = ray.bend * (tEnd - t) * (tEnd - t);
                    if (std::min(z0, z1) - sag > highest || std::max(z0, z1) < baseZ_) return false;
                    if (i < 0 || j < 0 || i >= blocksI_ || j >= blocksJ_) return false;
                    if (hasRim_[static_cast<size_t>(j * blocksI_ + i)])
                        found = wallInBlock(ray, t, tEnd);
                    return found.has_value();
                });
    return found;
}

}  // namespace terray
