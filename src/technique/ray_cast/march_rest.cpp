// SPDX-License-Identifier: Apache-2.0
// What a march leaves: columns at a tile's sides, rays of which nothing is known, and those that
// their few cells did not decide.
#include <cmath>
#include <limits>

#include "technique/ray_cast/marcher.h"

namespace terray {
namespace {

/// Level at which a ray that has begun near its hit enters a tile.
constexpr int kNearLevel = 3;

}  // namespace

/// Columns at the tile's sides lack a ray between which they stand: traced for the whole chunk.
void Marcher::traceEdges() {
    const int step = neighbours_.upwards ? -1 : 1;
    const auto trace = [&](int begin, int end) {
        Loose loose;
        for (int row = chunkFirst_; row != chunkLast_ + step; row += step)
            for (int c = begin; c < end; ++c) loose.add(c, row);
        if (loose.count > 0) traceFresh(loose, pixelBeam(begin, end, chunkFirst_, chunkLast_));
    };
    trace(0, firstInner());
    trace(lastInner() + 1, tile_.width);
}

/// What the lanes of a row have left goes to the tracer.
void Marcher::traceLeft(int row, std::span<const int32_t> left) {
    Loose begun, fresh;
    fixHits(row, left);
    const auto traceFreshOnes = [&] {
        traceFresh(fresh, pixelBeam(fresh.column[0], fresh.column[fresh.count - 1] + 1, row, row));
        fresh.count = 0;
    };
    for (const int c : left) {
        if (lanes_.result[c] != kMarchLeft) continue;
        if (lanes_.begun[c] != 0) {
            if (begun.count == begun.column.size()) {
                traceBegun(begun);
                begun.count = 0;
            }
            begun.add(c, row);
            continue;
        }
        // Bundles of a few columns reach farther.
        const bool wide = fresh.count > 0 && c >= fresh.column[0] + kGroupColumns;
        if (wide || fresh.count == fresh.column.size()) traceFreshOnes();
        fresh.add(c, row);
    }
    if (begun.count > 0) traceBegun(begun);
    if (fresh.count > 0) traceFreshOnes();
}

/// Distances of the hits whose cells are known; what is not found there is left.
void Marcher::fixHits(int row, std::span<const int32_t> left) {
    for (size_t next = 0; next < left.size();) {
        Loose loose;
        for (; next < left.size() && loose.count < loose.column.size(); ++next)
            if (lanes_.result[left[next]] == kMarchCell) loose.add(left[next], row);
        if (loose.count == 0) continue;
        RayBatch batch;
        std::array<Hit, kBatchRays> found;
        for (size_t k = 0; k < loose.count; ++k) found[k] = hitAt(row, loose.column[k]);
        fillBatch(loose, batch);
        hitsInCells(cut_, batch, static_cast<int>(loose.count),
                    std::span(found).first(loose.count));
        for (size_t k = 0; k < loose.count; ++k) {
            const int column = loose.column[k];
            if (!isHit(found[k])) {
                lanes_.result[column] = kMarchLeft;  // after all
                continue;
            }
            hitAt(row, column) = found[k];
            lanes_.forward[column] = aheadOf(column, row, static_cast<double>(found[k].t));
            ++counters_.rays;
            ++counters_.columns;
            ++counters_.hits;
        }
    }
}

void Marcher::fillBatch(const Loose& loose, RayBatch& batch) const {
    std::array<double, kBatchRays> x, y;
    for (size_t k = 0; k < loose.count; ++k) {
        x[k] = px(loose.column[k]);
        y[k] = py(loose.row[k]);
    }
    rays_.fillBatch(std::span(x).first(loose.count), std::span(y).first(loose.count), 0.0, batch);
}

/// Rays that the row below has told where to begin, from where their lanes have come to.
void Marcher::traceBegun(const Loose& loose) {
    RayBatch batch;
    fillBatch(loose, batch);
    for (size_t k = 0; k < loose.count; ++k)
        batch.clear[k] = std::max(static_cast<double>(lanes_.clear[loose.column[k]]), 0.0);
    counters_.columns += loose.count;
    trace(batch, loose, kNearLevel);
    for (size_t k = 0; k < loose.count; ++k) {
        Hit& hit = hitAt(loose.row[k], loose.column[k]);
        const int steps = hit.steps + lanes_.steps[loose.column[k]];
        hit.steps = static_cast<uint16_t>(std::min(steps, 0xFFFF));
    }
}

/// Rays of which nothing is known, from where a bundle of all of them ends.
void Marcher::traceFresh(const Loose& loose, const Beam& beam) {
    RayBatch batch;
    fillBatch(loose, batch);
    BeamWalk walk(cut_, beam);
    const double clear = walk.clearTo(std::numeric_limits<double>::infinity());
    for (size_t k = 0; k < loose.count; ++k) {
        const RayTerms& column = columns_[static_cast<size_t>(loose.column[k])];
        batch.clear[k] =
            clear * std::sqrt(column[kTermLength2] + rowTerms(loose.row[k])[kTermLength2]);
    }
    counters_.beams += loose.count;
    trace(batch, loose, walk.level());
}

void Marcher::trace(RayBatch& batch, const Loose& loose, int level) {
    std::array<Hit, kBatchRays> found;
    firstHits(cut_, batch, static_cast<int>(loose.count), level,
              std::span(found).first(loose.count), counters_);
    for (size_t k = 0; k < loose.count; ++k) {
        const int c = loose.column[k], row = loose.row[k];
        const Hit& hit = hitAt(row, c) = found[k];
        lanes_.past[c] = !isHit(hit);
        lanes_.disturbed[c / kGroupColumns] |= !isHit(hit);
        float& forward = forwardOf(c, row);
        forward = -1.0f;
        if (!batch.above[k]) continue;
        forward = 0.0f;  // all that is known of a ray that is never near the terrain
        if (!isHit(hit) && batch.end[k] < batch.begin[k]) continue;
        const double t = isHit(hit) ? static_cast<double>(hit.t) : batch.end[k];
        forward = aheadOf(c, row, t);
    }
}

}  // namespace terray
