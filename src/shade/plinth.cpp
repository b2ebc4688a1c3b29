// SPDX-License-Identifier: Apache-2.0
// Walks rays over blocks of cells that list the faces in them. Under the ground's rim a ray that
// enters meets a face; one that leaves, or comes down to the base, came in through a hole.
#include "shade/plinth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/height.h"

namespace terray {
namespace {

/// Depth of the plinth under the lowest ground: a share of the terrain's larger side.
constexpr double kThickness = 0.03;
/// Blocks along the terrain's larger side, at most.
constexpr double kBlocks = 64;
/// Cells by which faces are listed in blocks beyond their own, against rounding.
constexpr double kMargin = 1e-3;
/// Heights of one face's upper edge, at most.
constexpr double kMostTops = 1 << 20;

/// Cells a unit of t, not 0.
double speedOf(const Ray& ray) {
    return std::max(std::sqrt(ray.dx * ray.dx + ray.dy * ray.dy), 1e-12);
}

double heightOn(const Ray& ray, double t) { return ray.z + (ray.dz + ray.bend * t) * t; }

/// Calls visit(i, j, tIn, tOut) for each square of `size` cells along a ray, in order, until it
/// returns true.
template <class Visit>
void walkSquares(const Ray& ray, double size, double tIn, double tOut, const Visit& visit) {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    // A hair beyond the start, so that a ray that starts on a border is in the square ahead.
    const double start = tIn + 1e-9 * (tOut - tIn);
    auto i = static_cast<int64_t>(std::floor((ray.x + ray.dx * start) / size));
    auto j = static_cast<int64_t>(std::floor((ray.y + ray.dy * start) / size));
    const int64_t stepI = ray.dx < 0 ? -1 : 1, stepJ = ray.dy < 0 ? -1 : 1;
    const auto crossing = [&](int64_t square, int64_t step, double from, double speed) {
        if (speed == 0) return kNever;
        return (static_cast<double>(square + (step > 0 ? 1 : 0)) * size - from) / speed;
    };
    for (double t = tIn; t < tOut;) {
        const double nextI = crossing(i, stepI, ray.x, ray.dx);
        const double nextJ = crossing(j, stepJ, ray.y, ray.dy);
        const double next = std::min(nextI, nextJ);
        if (visit(i, j, t, std::min(next, tOut)) || next == kNever) return;
        (nextI <= nextJ ? i : j) += nextI <= nextJ ? stepI : stepJ;
        t = std::max(next, t);
    }
}

}  // namespace

Plinth::Plinth(const TerrainCut& cut, const TerrainInfo& info, const RayFrame& rays,
               std::span<const RimLoop> rims)
    : cut_(cut), cellsI_(info.scheme.columns - 1), cellsJ_(info.scheme.rows - 1) {
    const auto columns = static_cast<double>(cellsI_), rows = static_cast<double>(cellsJ_);
    const double side = std::max(columns * info.worldFromLattice.columnLength(),
                                 rows * info.worldFromLattice.rowLength());
    baseZ_ = static_cast<double>(info.minZ) - kThickness * side / rays.exaggeration();
    blockSize_ = std::max(std::ceil(std::max(columns, rows) / kBlocks), 1.0);
    blocksI_ = static_cast<int64_t>(std::ceil(columns / blockSize_));
    blocksJ_ = static_cast<int64_t>(std::ceil(rows / blockSize_));
    for (const RimLoop& loop : rims) addLoop(loop, info.worldFromLattice);
    sortIntoBlocks();
}

void Plinth::addLoop(const RimLoop& loop, const Affine2& worldFromLattice) {
    // The last cells of an overview may reach beyond the raster.
    const Vec2 last{static_cast<double>(cellsI_), static_cast<double>(cellsJ_)};
    const double upright = worldFromLattice.det() < 0 ? 1.0 : -1.0;  // j down is north up
    for (size_t k = 0; k < loop.size(); ++k) {
        const Vec2 from = glm::min(loop[k], last);
        const Vec2 to = glm::min(loop[(k + 1) % loop.size()], last);
        if (from == to) continue;
        Face face{from, to - from, {}, 0, 0};
        const Vec2 a = worldFromLattice.worldFromLattice({from.x, from.y});
        const Vec2 b = worldFromLattice.worldFromLattice({to.x, to.y});
        const Vec2 along = glm::normalize(b - a);
        face.outwards = glm::vec3{-along.y * upright, along.x * upright, 0};
        addTops(face);
        faces_.push_back(face);
    }
}

void Plinth::addTops(Face& face) {
    const double length = glm::length(face.along);
    face.top = tops_.size();
    face.tops = 1 + static_cast<size_t>(std::clamp(std::ceil(length), 1.0, kMostTops));
    const Vec2 last{static_cast<double>(cellsI_), static_cast<double>(cellsJ_)};
    const Vec2 inwards = Vec2{-face.along.y, face.along.x} / length;
    constexpr int kReach = 8;  // cells inwards for a place at the rim that is a hole
    float top = std::numeric_limits<float>::quiet_NaN();
    for (size_t k = 0; k < face.tops; ++k) {
        const double share = static_cast<double>(k) / static_cast<double>(face.tops - 1);
        for (int step = 0; step <= kReach; ++step) {
            const Vec2 p = glm::clamp(face.from + share * face.along + inwards * (0.5 * step),
                                      Vec2{0, 0}, last);
            const SurfaceCell cell = surfaceCellAt(cut_, p.x, p.y);
            if (cell.slot == kNoSlot) continue;
            top = static_cast<float>(cell.height(cut_.surface));
            break;
        }
        tops_.push_back(top);  // where there is none, as the one before
    }
    const auto first = tops_.begin() + static_cast<std::ptrdiff_t>(face.top);
    const auto known = std::find_if(first, tops_.end(), [](float z) { return !std::isnan(z); });
    std::fill(first, known, known == tops_.end() ? static_cast<float>(baseZ_) : *known);
}

/// Calls visit(block) for the blocks that a face passes, and some beside it.
template <class Visit>
void Plinth::visitBlocks(const Face& face, const Visit& visit) const {
    const Vec2 to = face.from + face.along;
    const auto block = [&](double place, int64_t blocks) {
        return std::clamp<int64_t>(static_cast<int64_t>(std::floor(place / blockSize_)), 0,
                                   blocks - 1);
    };
    const double low = std::min(face.from.y, to.y), high = std::max(face.from.y, to.y);
    for (int64_t row = block(low - kMargin, blocksJ_); row <= block(high + kMargin, blocksJ_);
         ++row) {
        // The part of the face within the row.
        double a = 0, b = 1;
        if (face.along.y != 0) {
            const double top = static_cast<double>(row) * blockSize_ - kMargin;
            a = std::clamp((top - face.from.y) / face.along.y, 0.0, 1.0);
            b = std::clamp((top + blockSize_ + 2 * kMargin - face.from.y) / face.along.y, 0.0, 1.0);
        }
        const double x0 = face.from.x + a * face.along.x, x1 = face.from.x + b * face.along.x;
        const int64_t end = block(std::max(x0, x1) + kMargin, blocksI_);
        for (int64_t column = block(std::min(x0, x1) - kMargin, blocksI_); column <= end; ++column)
            visit(static_cast<size_t>(row * blocksI_ + column));
    }
}

void Plinth::sortIntoBlocks() {
    const auto count = static_cast<size_t>(blocksI_ * blocksJ_);
    firstFace_.assign(count + 1, 0);
    for (const Face& face : faces_) visitBlocks(face, [&](size_t b) { ++firstFace_[b + 1]; });
    for (size_t b = 0; b < count; ++b) firstFace_[b + 1] += firstFace_[b];
    faceList_.resize(firstFace_[count]);
    std::vector<uint32_t> next(firstFace_.begin(), firstFace_.end() - 1);
    for (uint32_t f = 0; f < faces_.size(); ++f)
        visitBlocks(faces_[f], [&](size_t b) { faceList_[next[b]++] = f; });
    states_.assign(count, Block::HasFaces);
    for (size_t b = 0; b < count; ++b) {
        if (firstFace_[b] != firstFace_[b + 1]) continue;
        const auto row = static_cast<int64_t>(b) / blocksI_,
                   column = static_cast<int64_t>(b) % blocksI_;
        const bool inside = isInside((static_cast<double>(column) + 0.5) * blockSize_,
                                     (static_cast<double>(row) + 0.5) * blockSize_);
        states_[b] = inside ? Block::Inside : Block::Outside;
    }
}

std::span<const uint32_t> Plinth::facesIn(int64_t block) const {
    const auto b = static_cast<size_t>(block);
    return std::span(faceList_).subspan(firstFace_[b], firstFace_[b + 1] - firstFace_[b]);
}

/// Counts the faces to the right of a place; a face counts in the block that it is crossed in.
bool Plinth::isInside(double i, double j) const {
    const auto row = static_cast<int64_t>(std::floor(j / blockSize_));
    auto column = static_cast<int64_t>(std::floor(i / blockSize_));
    if (row < 0 || row >= blocksJ_ || column >= blocksI_) return false;
    bool inside = false;
    for (column = std::max<int64_t>(column, 0); column < blocksI_; ++column) {
        const int64_t block = row * blocksI_ + column;
        const Block state = states_[static_cast<size_t>(block)];
        if (state != Block::HasFaces) return inside != (state == Block::Inside);
        for (const uint32_t f : facesIn(block)) {
            const Face& face = faces_[f];
            const double to = face.from.y + face.along.y;
            if ((face.from.y <= j) == (to <= j)) continue;
            const double x = face.from.x + (j - face.from.y) / face.along.y * face.along.x;
            const auto at = std::clamp<int64_t>(static_cast<int64_t>(std::floor(x / blockSize_)), 0,
                                                blocksI_ - 1);
            if (x > i && at == column) inside = !inside;
        }
    }
    return inside;
}

bool Plinth::isUnder(double i, double j) const {
    // On the raster's own border a place counts as inside.
    const double x = std::clamp(i, kMargin, static_cast<double>(cellsI_) - kMargin);
    const double y = std::clamp(j, kMargin, static_cast<double>(cellsJ_) - kMargin);
    return isInside(x, y);
}

double Plinth::topAt(const Face& face, double share) const {
    const double x = share * static_cast<double>(face.tops - 1);
    const size_t k = std::min(static_cast<size_t>(x), face.tops - 2);
    const double a = tops_[face.top + k], b = tops_[face.top + k + 1];
    return a + (x - static_cast<double>(k)) * (b - a);
}

/// The first face of a block that a ray crosses between the base and the ground's rim.
std::optional<Plinth::Crossing> Plinth::firstCrossing(const Ray& ray, int64_t block, double tIn,
                                                      double tOut) const {
    std::optional<Crossing> first;
    const double slack = kMargin / speedOf(ray);
    double end = tOut + slack;
    for (const uint32_t f : facesIn(block)) {
        const Face& face = faces_[f];
        const double across = ray.dx * face.along.y - ray.dy * face.along.x;
        if (across == 0) continue;
        const double x = face.from.x - ray.x, y = face.from.y - ray.y;
        const double t = (x * face.along.y - y * face.along.x) / across;
        const double share = (x * ray.dy - y * ray.dx) / across;
        if (!(t >= tIn - slack && t <= end && t >= 0 && share >= 0 && share <= 1)) continue;
        const double z = heightOn(ray, t);
        if (z < baseZ_ || z > topAt(face, share)) continue;
        first = Crossing{t, &face, across < 0};
        end = t;
    }
    return first;
}

/// Where a ray passes the level of the base: from above within the rim it came through a hole, from
/// below it sees the underside. `tOut` is cut where nothing can follow.
std::optional<Plinth::Seen> Plinth::seenAtBase(const Ray& ray, double& tOut) const {
    const double above = ray.z - baseZ_;
    // Roots of bend t^2 + dz t + above without cancellation.
    const double root = ray.dz * ray.dz - 4 * ray.bend * above;
    if (root < 0) return std::nullopt;
    const double q = -0.5 * (ray.dz + std::copysign(std::sqrt(root), ray.dz));
    double t = tOut;
    for (const double r : {q != 0 ? above / q : -1.0, ray.bend != 0 ? q / ray.bend : -1.0})
        if (r > 0) t = std::min(t, r);
    if (!(t < tOut)) return std::nullopt;
    const bool fromAbove = above > 0;
    if (fromAbove) tOut = t;
    if (!isInside(ray.x + ray.dx * t, ray.y + ray.dy * t)) return std::nullopt;
    tOut = t;
    return Seen{static_cast<float>(t), {0, 0, fromAbove ? 1 : -1}, fromAbove};
}

std::optional<Plinth::Seen> Plinth::firstSeen(const Ray& ray, double tMax) const {
    double tIn = 0, tOut = tMax;
    // Nothing stands above the highest ground; bent rays come down later than straight ones.
    const auto highest = static_cast<double>(cut_.maxZ);
    if (ray.z > highest) {
        if (ray.dz >= 0) return std::nullopt;
        tIn = (highest - ray.z) / ray.dz;
        if (tIn >= tOut) return std::nullopt;
    }
    std::optional<Seen> seen = seenAtBase(ray, tOut);
    const auto clip = [&](double from, double speed, double last) {
        if (speed == 0) {
            if (from < 0 || from > last) tOut = -1;
            return;
        }
        const double a = (0 - from) / speed, b = (last - from) / speed;
        tIn = std::max(tIn, std::min(a, b));
        tOut = std::min(tOut, std::max(a, b));
    };
    // A ray on the raster's border still crosses the faces there.
    const double before = kMargin / speedOf(ray);
    clip(ray.x, ray.dx, static_cast<double>(cellsI_));
    clip(ray.y, ray.dy, static_cast<double>(cellsJ_));
    tIn -= before;
    tOut += before;
    if (!(tIn < tOut)) return seen;
    walkSquares(ray, blockSize_, tIn, tOut, [&](int64_t i, int64_t j, double t, double tEnd) {
        i = std::clamp<int64_t>(i, 0, blocksI_ - 1);
        j = std::clamp<int64_t>(j, 0, blocksJ_ - 1);
        const auto crossing = firstCrossing(ray, j * blocksI_ + i, t, tEnd);
        if (!crossing || crossing->t > tMax) return false;
        if (seen && static_cast<double>(seen->t) < crossing->t) return true;
        seen = crossing->enters
                   ? Seen{static_cast<float>(crossing->t), crossing->face->outwards, false}
                   : Seen{static_cast<float>(crossing->t), {0, 0, 1}, true};
        return true;
    });
    return seen;
}

}  // namespace terray
