// SPDX-License-Identifier: Apache-2.0
// Strips [k, k + 1] + shear * row, a little widened, are swept from the far row to row 0. A strip
// is a bundle of parallel rays: the bounds of a row follow from those of the row before it.
#include "kernel/sweep/sun_tile.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "kernel/sweep/sun_rows.h"

namespace terray {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Strips are wider than a cell by this on both sides, more than lanes err about a ray's column.
constexpr double kWiden = 1.0 / 1024;
constexpr int kPad = 8;  ///< columns beside the posts of a row
constexpr int kRowPosts = kSlotCells + 1 + 2 * kPad;
constexpr int kRowLength = 544;    ///< with room for whole lanes
constexpr int kBlockRows = 64;     ///< decoded at once
constexpr int kFirstStrip = -520;  ///< of the state
constexpr int kStrips = 520 + kSlotCells + 16;

int floorOf(double v) { return static_cast<int>(std::floor(v)); }

/// Decoded rows of posts in the sun's axes, a block at a time, repeated beyond the last that
/// exists.
class PostRowsToSun {
public:
    PostRowsToSun(const TerrainCut& cut, const SunAxes& axes, float anchor, const TileToSweep& tile)
        : cut_(cut), axes_(axes), anchor_(anchor), tile_(tile) {}

    /// Posts of a row; column 0 is at [kPad].
    const float* row(int r) {
        if (r < first_ || r >= first_ + kBlockRows)
            load(std::max(r - kBlockRows + 1, tile_.firstRow));
        return rows_[static_cast<size_t>(r - first_)].data();
    }

private:
    template <class Post>
    void loadAs(const Post* posts, int last) {
        const float step = tile_.desc->zStep;
        const float base = sizeof(Post) == 2 ? tile_.desc->z0 - anchor_ : -anchor_;
        const bool mirroredColumns = axes_.transposed ? axes_.mirroredY : axes_.mirroredX;
        const bool mirroredRows = axes_.transposed ? axes_.mirroredX : axes_.mirroredY;
        const int count = last - first_ + 1, columns = tile_.lastColumn - tile_.firstColumn + 1;
        const int firstRow = mirroredRows ? kSlotCells - last : first_;
        const int firstColumn = mirroredColumns ? kSlotCells - tile_.lastColumn : tile_.firstColumn;
        const auto rowAt = [&](int k) {
            return rows_[static_cast<size_t>(mirroredRows ? count - 1 - k : k)].data() + kPad +
                   tile_.firstColumn;
        };
        if (axes_.transposed) {
            // Columns of the sun's rows are rows of posts: read a few posts of each.
            for (int c = 0; c < columns; ++c)
                decodePosts(posts + (firstColumn + c) * kPostStride + firstRow, count, step, base,
                            pieces_[static_cast<size_t>(c)].data());
            for (int k = 0; k < count; ++k) {
                float* to = rowAt(k);
                for (int c = 0; c < columns; ++c)
                    to[c] = pieces_[static_cast<size_t>(c)][static_cast<size_t>(k)];
            }
        } else {
            for (int k = 0; k < count; ++k)
                decodePosts(posts + (firstRow + k) * kPostStride + firstColumn, columns, step, base,
                            rowAt(k));
        }
        for (int k = 0; mirroredColumns && k < count; ++k)
            std::reverse(rowAt(k), rowAt(k) + columns);
    }

    void load(int first) {
        first_ = first;
        const int last = std::min(first + kBlockRows - 1, tile_.lastRow);
        if (cut_.format == 1)
            loadAs(static_cast<const float*>(cut_.posts) + tile_.desc->posts, last);
        else
            loadAs(static_cast<const uint16_t*>(cut_.posts) + tile_.desc->posts, last);
        for (int k = 0; k <= last - first_; ++k) {
            auto& row = rows_[static_cast<size_t>(k)];
            const auto begin = row.begin() + kPad;
            std::fill(row.begin(), begin + tile_.firstColumn, begin[tile_.firstColumn]);
            std::fill(begin + tile_.lastColumn + 1, row.end(), begin[tile_.lastColumn]);
        }
    }

    const TerrainCut& cut_;
    const SunAxes& axes_;
    float anchor_;
    const TileToSweep& tile_;
    int first_ = 1 << 20;
    std::array<std::array<float, kRowLength>, kBlockRows> rows_;
    std::array<std::array<float, kBlockRows>, kSlotCells + 1> pieces_;
};

class TileSweep {
public:
    TileSweep(const TerrainCut& cut, const SunAxes& axes, const HeightScale& scale,
              const TileToSweep& tile, const TileInflow& in, TileOutflow& out, uint32_t* entries)
        : shear_(axes.shear),
          scale_(scale),
          tile_(tile),
          in_(in),
          out_(out),
          entries_(entries),
          posts_(cut, axes, scale.anchorZ, tile) {}

    void run();

private:
    float& free(int strip) { return free_[static_cast<size_t>(strip - kFirstStrip)]; }
    float& caught(int strip) { return caught_[static_cast<size_t>(strip - kFirstStrip)]; }
    int firstOf(int row) const { return floorOf(-shear_ * row - kWiden); }
    int lastOf(int row) const { return floorOf(tile_.columnsEnd - shear_ * row + kWiden); }
    int baseOf(int row) const {
        return static_cast<int>(firstStrip(static_cast<float>(shear_), static_cast<float>(row)));
    }
    double dropAt(double column, int row) const {
        return tile_.drop + tile_.dropPerColumn * column + tile_.dropPerRow * row;
    }
    /// Entry of a strip in a row that keeps entries: row 0 is the next tile's.
    uint32_t* entryOf(int row, int strip) {
        return entries_ + (row / kSweepStep - 1) * kSweepStride + (strip - baseOf(row));
    }
    float slack() const;
    SunBand bandAt(int row) const;
    void startAt(int row);
    void admitSide(int row);
    void publishSide(int row, const float* here);
    void keepIn(int row, SunRow& s);
    void step(int row, const float* here);
    void handOn();

    double shear_;
    const HeightScale& scale_;
    const TileToSweep& tile_;
    const TileInflow& in_;
    TileOutflow& out_;
    uint32_t* entries_;
    PostRowsToSun posts_;
    std::array<float, kStrips> free_, caught_;
    std::array<float, kRowLength> edges_, twist_, holes_, before_;
    bool anyHoles_ = false;
};

/// Error of a drop: its spread over a strip, the ray's slope, and the rounding of one step.
float TileSweep::slack() const {
    const double largest = std::fabs(tile_.drop) + kSlotCells * (std::fabs(tile_.dropPerColumn) +
                                                                 std::fabs(tile_.dropPerRow));
    return static_cast<float>(2.5 * std::fabs(tile_.dropPerColumn) + tile_.slack + 4e-7 * largest +
                              2.4e-7 * static_cast<double>(scale_.reach));
}

/// From `row` to the next. Ground faces the sun for certain if rays gain an eighth of their rise on
/// it: so lanes can trust it, however they round.
SunBand TileSweep::bandAt(int row) const {
    const double rise = std::min(dropAt(0, row), dropAt(kSlotCells, row));
    const float least = static_cast<float>(rise) - slack();
    const auto arc = static_cast<float>(tile_.arc);
    return {static_cast<float>(shear_), least,
            (1 - kGainOnFacing) * (least - arc) - 2e-6f * scale_.reach, arc};
}

/// Bounds on the far row, from what enters there.
void TileSweep::startAt(int row) {
    free_.fill(-kInfinity);
    caught_.fill(kInfinity);
    const bool enters = tile_.rowsEnd >= kSlotCells;
    for (int strip = firstOf(row); strip <= lastOf(row); ++strip) {
        const double left = strip + shear_ * row - kWiden;
        const int first = std::clamp(floorOf(left), 0, kSlotCells - 1);
        const int last = std::clamp(floorOf(std::min(left + 1 + 2 * kWiden, tile_.columnsEnd)), 0,
                                    kSlotCells - 1);
        if (!enters) caught(strip) = -kInfinity;
        for (int c = first; enters && c <= last; ++c) {
            free(strip) = std::max(free(strip), in_.far.free[static_cast<size_t>(c)]);
            caught(strip) = std::min(caught(strip), in_.far.caught[static_cast<size_t>(c)]);
        }
    }
}

/// Strips that pass the far column between rows `row` and `row` + 1 meet what comes in there.
void TileSweep::admitSide(int row) {
    const double rim = tile_.columnsEnd - kWiden;
    const int first = floorOf(rim - shear_ * (row + 1) - 1) + 1;
    const bool enters = tile_.columnsEnd >= kSlotCells;
    const auto at = static_cast<size_t>(row);
    const float most = static_cast<float>(dropAt(kSlotCells / 2.0, row)) + slack() +
                       static_cast<float>(kSlotCells * std::fabs(tile_.dropPerColumn));
    const float inFree = enters ? in_.side.free[at] + most : -kInfinity;
    const float inCaught = enters ? in_.side.caught[at] - most : -kInfinity;
    for (int strip = std::max(first, kFirstStrip); strip <= lastOf(row); ++strip) {
        free(strip) = std::max(free(strip), inFree);
        caught(strip) = std::min(caught(strip), inCaught);
    }
}

/// Bounds where rays come in through column 0 between rows `row` and `row` + 1: they go on through
/// columns 0 .. shear to row + 1, whose bounds still stand.
void TileSweep::publishSide(int row, const float* here) {
    float free = -kInfinity, caught = kInfinity;
    const int last = floorOf(-shear_ * row + kWiden);
    for (int strip = firstOf(row + 1); strip <= last; ++strip) {
        free = std::max(free, this->free(strip));
        caught = std::min(caught, this->caught(strip));
    }
    bool hole = false;
    for (size_t c = kPad; c <= kPad + 2; ++c) {
        for (const float z : {here[c], before_[c]}) free = z > free ? z : free;
        hole = hole || (anyHoles_ && holes_[c] != 0.0f);
    }
    const float most = static_cast<float>(dropAt(0, row)) + slack() +
                       static_cast<float>(2 * std::fabs(tile_.dropPerColumn));
    const auto at = static_cast<size_t>(row);
    out_.side.free[at] = free;
    out_.side.caught[at] = hole ? -kInfinity : caught - std::max(most, 0.0f);
}

/// Where the bounds of a row go: `caught` to its own entries, `free` to those of the kept row
/// before, as far as its strips reach there.
void TileSweep::keepIn(int row, SunRow& s) {
    const int first = firstOf(row), last = lastOf(row), kept = row + kSweepStep;
    s.codeZ = scale_.codeZ;
    s.codesPerMetre = scale_.codesPerMetre;
    s.free = &free(first);
    s.caught = &caught(first);
    s.count = last - first + 1;
    s.entries = s.kept = nullptr;
    if (row % kSweepStep != 0) return;
    if (row > 0) s.entries = entryOf(row, first);
    if (kept > std::ceil(tile_.rowsEnd)) return;
    s.keptCount = std::min(lastOf(kept), last) - first + 1;
    if (s.keptCount > 0) s.kept = entryOf(kept, first);
}

/// From row + 1 to row, whose posts are `here`.
void TileSweep::step(int row, const float* here) {
    const double shift = shear_ * row;
    const int first = firstOf(row);
    const double left = shift - kWiden, right = 1 + shift + kWiden;
    const double start = left + shear_, end = right + shear_;
    const int leftColumn = floorOf(left), endColumn = floorOf(end);
    const int origin = kPad + first + leftColumn;  // the column under the first strip
    SunRow s;
    keepIn(row, s);
    s.here = here + origin;
    s.ahead = before_.data() + origin;
    s.edges = edges_.data() + origin;
    s.twist = twist_.data() + origin;
    s.holes = anyHoles_ ? holes_.data() + origin : nullptr;
    const int across = endColumn - leftColumn;
    for (int k = 0; k < 4; ++k) s.cell[k] = std::min(k, across);
    for (int k = 0; k < 3; ++k) s.edge[k] = std::min(k + 1, across);
    s.right = floorOf(right) - leftColumn;
    s.leftAhead = floorOf(start) - leftColumn;
    s.rightAhead = across;
    s.leftPlace = static_cast<float>(left - leftColumn);
    s.rightPlace = static_cast<float>(right - floorOf(right));
    s.leftPlaceAhead = static_cast<float>(start - floorOf(start));
    s.rightPlaceAhead = static_cast<float>(end - endColumn);
    s.drop = static_cast<float>(dropAt(first + 0.5 + shift, row));
    s.dropPerStrip = static_cast<float>(tile_.dropPerColumn);
    s.slack = slack();
    sweepRow(s);
}

/// At row 0, to a tile that knows nothing of the ground here. Row 0 is in before_.
void TileSweep::handOn() {
    const auto post = [&](int column) { return before_[static_cast<size_t>(column + kPad)]; };
    for (int c = 0; c < kSlotCells; ++c) {
        float top = free(c);
        for (int column = c - 1; column <= c + 2; ++column)
            top = post(column) > top ? post(column) : top;
        out_.near.free[static_cast<size_t>(c)] = top;
        out_.near.caught[static_cast<size_t>(c)] = caught(c);
    }
}

void TileSweep::run() {
    out_.near.free.fill(-kInfinity);
    out_.near.caught.fill(-kInfinity);
    out_.side = out_.near;
    const int top = static_cast<int>(std::ceil(tile_.rowsEnd));
    startAt(top);
    SunRow far;
    keepIn(top, far);
    codeRow(far);
    std::copy_n(posts_.row(top), kRowLength, before_.data());
    for (int row = top - 1; row >= tile_.firstRow; --row) {
        const float* here = posts_.row(row);
        anyHoles_ =
            prepareBand(here, before_.data(), kRowPosts, bandAt(row), edges_.data(), twist_.data());
        if (anyHoles_) markHoles(here, before_.data(), kRowPosts, holes_.data());
        admitSide(row);
        publishSide(row, here);
        step(row, here);
        std::copy_n(here, kRowLength, before_.data());
    }
    if (tile_.firstRow == 0) handOn();
}

}  // namespace

void sweepTile(const TerrainCut& cut, const SunAxes& axes, const HeightScale& scale,
               const TileToSweep& tile, const TileInflow& inflow, TileOutflow& outflow,
               uint32_t* entries) {
    TileSweep(cut, axes, scale, tile, inflow, outflow, entries).run();
}

}  // namespace terray
