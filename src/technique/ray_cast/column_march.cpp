// SPDX-License-Identifier: Apache-2.0
// Marches an image tile in rows from the nadir's side outwards (docs/traversal.md has the proof).
#include "technique/ray_cast/column_march.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/assert.h"
#include "technique/ray_cast/marcher.h"

namespace terray {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Rays nearer to the vertical than this (metres ahead per metre) do not share: "ahead" says too
/// little there.
constexpr double kLeastAhead = 0.05;

}  // namespace

/// +1 if all rays of a row look ahead, -1 if all look back, 0 if one is too near the vertical.
int Marcher::sideOf(int row) const {
    const RayTerms terms = rays_.rowTerms(py(row));
    double least = kInfinity, most = -kInfinity;
    for (const int c : {0, tile_.width - 1}) {
        const RayTerms ray = sumOf(rays_.columnTerms(px(c)), terms);
        const double ahead = ray[kTermForward] / std::sqrt(ray[kTermLength2]);
        least = std::min(least, ahead);
        most = std::max(most, ahead);
    }
    return least > kLeastAhead ? 1 : most < -kLeastAhead ? -1 : 0;
}

void Marcher::turnTo(int side) {
    side_ = side;
    for (int c = 0; c < kMarchColumns; ++c) {
        RayTerms& column = columns_[static_cast<size_t>(c)];
        column = rays_.columnTerms(px(std::min(c, tile_.width - 1)));
        column[kTermForward0] *= side;
        column[kTermForward] *= side;
    }
    tellColumns();
}

void Marcher::march() {
    for (int first = 0; first < tile_.height;) {
        const int side = sideOf(first);
        int last = first;
        while (last + 1 < tile_.height && sideOf(last + 1) == side) ++last;
        if (side == 0) {
            castRows(first, last);
        } else {
            turnTo(side);
            marchRun(first, last);
        }
        first = last + 1;
    }
}

void Marcher::castRows(int first, int last) const {
    const int rows = last - first + 1;
    ImageTile part{tile_.x, tile_.y + first, tile_.width, rows};
    Vec2 offset = view_.offset;
    if (view_.turned) {
        part = {part.y, part.x, part.height, part.width};
        offset = {offset.y, offset.x};
    }
    castByBeams(cut_, frame_, part, offset, hits_.subspan(view_.indexOf(first, 0, stride_)),
                stride_, counters_);
}

void Marcher::marchRun(int first, int last) {
    eyeOutside_ = false;
    for (const int row : {first, last})
        for (const int c : {0, tile_.width - 1}) {
            const RayTerms ray = sumOf(columns_[static_cast<size_t>(c)], makeRow(row));
            const double x = ray[kTermX], y = ray[kTermY];
            if (x < 0 || y < 0 || x > cut_.cellsX || y > cut_.cellsY) eyeOutside_ = true;
        }
    forget();
    const auto whole =
        neighboursOf(rays_, {px(0), py(first), px(tile_.width - 1), py(last)}, side_, 1);
    if (!whole || whole->upwards) {
        for (int row = last; row >= first; row -= kChunkRows)
            if (!marchChunk(row, std::max(row - kChunkRows + 1, first), true)) forget();
    } else {
        for (int row = first; row <= last; row += kChunkRows)
            if (!marchChunk(row, std::min(row + kChunkRows - 1, last), false)) forget();
    }
}

/// Nothing is known of any row.
void Marcher::forget() {
    resetLanes(lanes_);
    for (auto& row : known_) std::fill(std::begin(row), std::end(row), -1.0f);
    rowsKnown_ = 0;
}

/// Whose hits tell the rows of a chunk where to begin: the next row's if no ground may hide above
/// it, or those of a row farther down if that is not so there.
std::optional<Neighbours> Marcher::chooseNeighbours(int top, int bottom) {
    const PixelBlock block{px(0), py(top), px(tile_.width - 1), py(bottom)};
    auto next = neighboursOf(rays_, block, side_, 1);
    if (!next) return next;
    const double farthest = 1.2 * static_cast<double>(farthestKnown());
    const auto hides = [&](const Neighbours& n) {
        return n.sharp.least(farthest) <= static_cast<double>(cut_.maxSharpness);
    };
    if (!hides(*next)) return next;
    for (int rows = 2; rows <= std::min(rowsKnown_, kMostRows); ++rows) {
        const auto n = neighboursOf(rays_, block, side_, rows);
        if (n && n->upwards == next->upwards && !hides(*n)) return n;
    }
    return next;
}

/// False if the chunk's rows cannot share in this order; they are cast then.
bool Marcher::marchChunk(int first, int last, bool upwards) {
    const int top = std::min(first, last), bottom = std::max(first, last);
    const auto neighbours = chooseNeighbours(top, bottom);
    if (!neighbours || neighbours->upwards != upwards ||
        neighbours->left() + neighbours->right() >= tile_.width) {
        castRows(top, bottom);
        return false;
    }
    neighbours_ = *neighbours;
    chunkFirst_ = first;
    chunkLast_ = last;
    const int step = neighbours_.upwards ? -1 : 1;
    for (int row = rowBelow(first), k = 0; row != last + step; row += step)
        rows_[static_cast<size_t>(k++)] = makeRow(row);
    for (auto& walk : sharp_) walk.reset();
    placeGroups(first, std::abs(last - first) + 1);
    for (int group = 0; group * kGroupColumns < tile_.width; ++group) lookBeyond(group);
    traceEdges();
    for (int row = first; row != last + step; row += step) marchOneRow(row);
    return true;
}

/// The bundle of the columns [begin, end) of some rows.
Beam Marcher::pixelBeam(int begin, int end, int firstRow, int lastRow) const {
    const int low = std::min(firstRow, lastRow), high = std::max(firstRow, lastRow);
    return beamOf(rays_, tile_.x + begin, tile_.y + low, end - begin, high - low + 1);
}

/// Where the row below has missed all, a bundle of the chunk's rays tells most of what is to be
/// told.
void Marcher::lookBeyond(int group) {
    int begin = group * kGroupColumns, end = std::min(begin + kGroupColumns, tile_.width);
    std::fill(lanes_.sure + begin, lanes_.sure + end, -1.0f);
    while (begin < end && lanes_.past[begin] == 0) ++begin;
    while (begin < end && lanes_.past[end - 1] == 0) --end;
    if (begin == end) return;
    BeamWalk walk(cut_, pixelBeam(begin, end, chunkFirst_, chunkLast_));
    const double clear = walk.clearTo(kInfinity);
    const RayTerms &left = columns_[static_cast<size_t>(begin)],
                   &right = columns_[static_cast<size_t>(end - 1)];
    const RayTerms &first = rowTerms(chunkFirst_), &last = rowTerms(chunkLast_);
    const auto leastOf = [&](RayTerm k) {
        return std::min(left[k], right[k]) + std::min(first[k], last[k]);
    };
    const double ahead = leastOf(kTermForward0) + 0.99999 * clear * leastOf(kTermForward);
    std::fill(lanes_.sure + begin, lanes_.sure + end,
              static_cast<float>(std::clamp(ahead, -1.0, 1e30)));
}

/// Ground that is sharp enough to hide between two rays of a row and to reach up to the next row.
bool Marcher::mayHideGround() const {
    if (neighbours_.first == 0 && neighbours_.last == 0) return false;
    if (cut_.hasHoles != 0 || cut_.unlikeMips != 0 || eyeOutside_) return true;
    const float farthest = greatestOf(lanes_.below, tile_.width);
    return static_cast<double>(cut_.maxSharpness) >=
           neighbours_.sharp.least(static_cast<double>(farthest));
}

/// A ray may begin where those of the row below hit only as far as no sharp ground reaches up to
/// them: between the two there could be something else (docs/traversal.md).
void Marcher::limitBegins(int row, const RayTerms& terms) {
    const int below = rowBelow(row);
    const RayTerms termsBelow = rowTerms(below);
    for (int begin = 0; begin < tile_.width; begin += kGroupColumns) {
        const int end = std::min(begin + kGroupColumns, tile_.width);
        const float farthest = greatestOf(lanes_.below + begin, end - begin);
        if (farthest <= 0) continue;
        // At one distance ahead the two rows differ in w, and so do the columns: linearly.
        const RayTerms& a = columns_[static_cast<size_t>(begin)];
        const RayTerms& b = columns_[static_cast<size_t>(end - 1)];
        const auto leastOf = [&](RayTerm k) {
            const double aside =
                std::fabs(b[k] - a[k]) / std::max(end - 1 - begin, 1) * kMarchReach;
            return std::min(a[k], b[k]) + std::min(terms[k], termsBelow[k]) - aside;
        };
        const double least0 = leastOf(kTermForward0), least = leastOf(kTermForward);
        auto& walk = sharp_[static_cast<size_t>(begin / kGroupColumns)];
        if (!walk)  // with the row below the chunk, from whose hits the first row begins
            walk.emplace(
                cut_,
                pixelBeam(begin - neighbours_.left(), end + neighbours_.right(),
                          rowBelow(chunkFirst_), chunkLast_),
                BeamWalk::Sharp{neighbours_.sharp.at,
                                neighbours_.sharp.perW *
                                    (std::max(a[kTermForward], b[kTermForward]) +
                                     std::max(terms[kTermForward], termsBelow[kTermForward]))});
        const double wanted =
            1.0001 * (static_cast<double>(farthest) - least0) / std::max(least, 1e-9);
        if (walk->reached() < wanted)
            walk->raiseFloor(rays_.pencilRay(px(begin - neighbours_.left()), py(below)).ray,
                             rays_.pencilRay(px(end - 1 + neighbours_.right()), py(below)).ray);
        const double clear = walk->clearTo(wanted);
        const auto limit = static_cast<float>(std::max(0.99999 * (clear * least + least0), 0.0));
        for (int c = begin; c < end; ++c) lanes_.limit[c] = clear >= wanted ? 1e30f : limit;
    }
}

void Marcher::marchOneRow(int row) {
    const RayTerms terms = rowTerms(row);
    lanes_.below = known(neighbours_.rows);
    if (mayHideGround())
        limitBegins(row, terms);
    else
        std::fill_n(lanes_.limit, kMarchColumns, 1e30f);
    Hit* const hits = view_.turned ? turnedHits_.data() : &hitAt(row, 0);
    const MarchCounts counts = marchRow(
        cut_, groups_.data(), {std::abs(row - chunkFirst_), neighbours_.first, neighbours_.last},
        firstInner(), lastInner() + 1, lanes_, hits);
    if (view_.turned)
        for (int c = firstInner(); c <= lastInner(); ++c)
            hitAt(row, c) = turnedHits_[static_cast<size_t>(c)];
    const auto done = static_cast<uint64_t>(lastInner() + 1 - firstInner() - counts.left);
    counters_.rays += done;
    counters_.columns += done;
    counters_.hits += static_cast<uint64_t>(counts.hits);
    counters_.steps += static_cast<uint64_t>(counts.steps);
    const float* edges = edges_[std::abs(row - chunkFirst_)];
    for (int c = 0; c < firstInner(); ++c) lanes_.forward[c] = edges[c];
    for (int c = lastInner() + 1; c < tile_.width; ++c) lanes_.forward[c] = edges[c];
    if (counts.left > 0)
        traceLeft(row, std::span(lanes_.left).first(static_cast<size_t>(counts.left)));
    ++rowsKnown_;
    std::copy_n(lanes_.forward, tile_.width, known(1));
}

void marchTile(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
               std::span<Hit> hits, size_t stride, TraceCounters& counters) {
    TERRAY_ASSERT(tile.width <= kMarchColumns && tile.height <= kMarchColumns);
    Marcher(cut, rays, viewFor(rays, tile, offset), hits, stride, counters).march();
}

}  // namespace terray