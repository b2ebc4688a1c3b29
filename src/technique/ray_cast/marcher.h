// SPDX-License-Identifier: Apache-2.0
// What the march of an image tile knows: of the tile, of its run of rows, and of the chunk of rows
// at hand.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>

#include "kernel/beam.h"
#include "kernel/columns.h"
#include "kernel/trace.h"
#include "technique/ray_cast/march_view.h"
#include "technique/ray_cast/neighbours.h"

namespace terray {

constexpr int kChunkRows =
    kMarchRows;  ///< rows that share an anchor and their checks for sharp ground
constexpr int kGroupColumns = kMarchGroupColumns;
/// A ray may begin where rays so many rows below it have hit: the farther below, the sharper the
/// ground must be that could hide between them.
constexpr int kMostRows = 4;
constexpr int kGroups = kMarchColumns / kGroupColumns;

inline RayTerms sumOf(const RayTerms& a, const RayTerms& b) {
    RayTerms sum;
    for (size_t k = 0; k < sum.size(); ++k) sum[k] = a[k] + b[k];
    return sum;
}

/// The greatest of some numbers, several at a time.
inline float greatestOf(const float* values, int count) {
    constexpr int kAtOnce = 16;
    if (count < kAtOnce) return *std::max_element(values, values + count);
    std::array<float, kAtOnce> most;
    std::copy_n(values, kAtOnce, most.begin());
    for (int first = kAtOnce; first < count; first += kAtOnce) {
        const float* next = values + std::min(first, count - kAtOnce);
        for (size_t k = 0; k < most.size(); ++k) most[k] = std::max(most[k], next[k]);
    }
    return *std::max_element(most.begin(), most.end());
}

/// Pixels of a tile that are traced one by one, at most a batch.
struct Loose {
    std::array<int, kBatchRays> column, row;
    size_t count = 0;
    void add(int c, int r) {
        column[count] = c;
        row[count++] = r;
    }
};

/// Marches one tile. confined.
class Marcher {
public:
    Marcher(const TerrainCut& cut, const RayFrame& frame, const MarchView& view,
            std::span<Hit> hits, size_t stride, TraceCounters& counters)
        : cut_(cut),
          frame_(frame),
          view_(view),
          rays_(view_.rays),
          tile_(view_.tile),
          hits_(hits),
          stride_(stride),
          counters_(counters) {}

    void march();

private:
    int sideOf(int row) const;
    void turnTo(int side);
    void marchRun(int first, int last);
    void forget();
    bool marchChunk(int first, int last, bool upwards);
    std::optional<Neighbours> chooseNeighbours(int top, int bottom);
    void marchOneRow(int row);
    void tellColumns();
    void placeGroups(int first, int rows);
    void placeGroup(int begin, int end, int first, int rows, float nearest);
    float nearestKnown(int begin, int end, float otherwise);
    void lookBeyond(int group);
    bool mayHideGround() const;
    void limitBegins(int row, const RayTerms& terms);
    void traceLeft(int row, std::span<const int32_t> left);
    void traceEdges();
    void fixHits(int row, std::span<const int32_t> left);
    void traceBegun(const Loose& loose);
    void traceFresh(const Loose& loose, const Beam& beam);
    void trace(RayBatch& batch, const Loose& loose, int level);
    void fillBatch(const Loose& loose, RayBatch& batch) const;
    Beam pixelBeam(int begin, int end, int firstRow, int lastRow) const;
    void castRows(int first, int last) const;
    Hit& hitAt(int row, int column) { return hits_[view_.indexOf(row, column, stride_)]; }
    double px(int column) const { return view_.px(column); }
    double py(int row) const { return view_.py(row); }
    /// The row from which a row knows where to begin.
    int rowBelow(int row) const {
        return row + (neighbours_.upwards ? neighbours_.rows : -neighbours_.rows);
    }
    /// What is known of the row `rows` below the one to come.
    float* known(int rows) {
        return known_[(rowsKnown_ + kMostRows + 1 - rows) % (kMostRows + 1)] + kMarchPad;
    }
    float farthestKnown() { return greatestOf(known(1), tile_.width); }
    /// Columns that have all rays of the row below that they need.
    int firstInner() const { return neighbours_.left(); }
    int lastInner() const { return tile_.width - 1 - neighbours_.right(); }
    RayTerms makeRow(int row) const {
        RayTerms terms = rays_.rowTerms(py(row));
        terms[kTermForward0] *= side_;
        terms[kTermForward] *= side_;
        return terms;
    }
    /// Of the chunk's rows, and of the one below them.
    const RayTerms& rowTerms(int row) const {
        return rows_[static_cast<size_t>(std::abs(row - rowBelow(chunkFirst_)))];
    }
    /// What is known of a ray once it has been traced.
    float& forwardOf(int column, int row) {
        const bool edge = column < firstInner() || column > lastInner();
        return edge ? edges_[std::abs(row - chunkFirst_)][column] : lanes_.forward[column];
    }
    /// Metres ahead, rounded down, at a distance along a ray.
    float aheadOf(int column, int row, double t) const {
        const RayTerms ray = sumOf(columns_[static_cast<size_t>(column)], rowTerms(row));
        const double w = (1 - 1e-6) * t / std::sqrt(ray[kTermLength2]);
        const double ahead = ray[kTermForward0] + w * ray[kTermForward];
        return static_cast<float>(std::clamp(ahead, 0.0, 1e30));
    }

    const TerrainCut& cut_;
    const RayFrame& frame_;
    const MarchView& view_;
    const RayFrame& rays_;
    const ImageTile& tile_;
    std::span<Hit> hits_;
    const size_t stride_;
    TraceCounters& counters_;
    std::array<RayTerms, kMarchColumns> columns_;
    std::array<std::array<double, kMarchColumns>, kTermCount> columnTerms_;
    RayTerms spread_{};
    // of the run
    int side_ = 1;  ///< -1: its rays look backwards
    bool eyeOutside_ = false;
    Neighbours neighbours_;
    /// Metres ahead known of the last rows' rays, in turns.
    alignas(64) float known_[kMostRows + 1][kMarchPad + kMarchColumns + kMarchPad];
    int rowsKnown_ = 0;
    // of the chunk
    int chunkFirst_ = 0, chunkLast_ = 0;
    std::array<RayTerms, kChunkRows + kMostRows> rows_{};
    std::array<MarchGroup, kMarchGroups> groups_;
    MarchLanes lanes_;
    std::array<std::optional<BeamWalk>, kGroups> sharp_;
    /// Metres ahead known of edge columns, by row of the chunk.
    float edges_[kChunkRows][kMarchColumns];
    std::array<Hit, kMarchColumns> turnedHits_;
};

}  // namespace terray
