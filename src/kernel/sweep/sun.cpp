// SPDX-License-Identifier: Apache-2.0
// The sun sweep over a whole cut: tiles in the order in which the light reaches them, what they
// hand on at their borders, and the table for the lanes.
#include "kernel/sweep/sun.h"

#include <oneapi/tbb/parallel_for_each.h>
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>

#include "kernel/simd/block.h"
#include "kernel/sweep/sun_tile.h"

namespace terray {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

void addDrawn(const TerrainCut& cut, int level, uint32_t x, uint32_t y,
              std::vector<uint32_t>& slots) {
    const DirectoryLevel& directory = cut.levels[level];
    if (x >= directory.columns || y >= directory.rows) return;
    const Square& square = cut.squares[directory.offset + uint64_t{y} * directory.columns + x];
    if (square.state == kSquareDrawn) slots.push_back(square.slot);
    if (square.state != kSquareDescend) return;
    for (uint32_t k = 0; k < 4; ++k)
        addDrawn(cut, level - 1, 2 * x + (k & 1), 2 * y + (k >> 1), slots);
}

int mipOf(const TerrainCut& cut, uint32_t slot) {
    return static_cast<int>(cut.tiles[slot].mipFlags & kTileMipMask);
}

SunAxes axesOf(const SunDirection& sun) {
    SunAxes axes;
    // Rows of posts are read faster than columns: a diagonal sun takes rows, however it is rounded.
    axes.transposed = std::fabs(sun.dx) > (1 + 1e-6) * std::fabs(sun.dy);
    axes.mirroredX = sun.dx < 0;
    axes.mirroredY = sun.dy < 0;
    axes.shear = axes.transposed ? std::fabs(sun.dy / sun.dx) : std::fabs(sun.dx / sun.dy);
    return axes;
}

/// The terrain's lattice in the sun's axes: mip-0 cells, columns across and rows towards the sun.
struct SunLattice {
    const TerrainCut& cut;
    const SunAxes& axes;

    struct Span {
        int64_t begin, end;
    };
    Span alongColumns(const TileDesc& tile) const { return along(tile, axes.transposed); }
    Span alongRows(const TileDesc& tile) const { return along(tile, !axes.transposed); }
    /// A column and a row of the tile that the terrain does not end before.
    int64_t columnInside(const TileDesc& tile) const { return inside(tile, axes.transposed); }
    int64_t rowInside(const TileDesc& tile) const { return inside(tile, !axes.transposed); }
    /// The drawn tile at a cell, and where its square (or the empty one) ends.
    struct Found {
        uint32_t slot = kNoSlot;
        int level = 0;
    };
    Found at(int64_t column, int64_t row) const {
        int64_t i = axes.transposed ? row : column, j = axes.transposed ? column : row;
        if (axes.mirroredX) i = -i - 1;
        if (axes.mirroredY) j = -j - 1;
        // Squares at the rim reach beyond the terrain.
        const DirectoryLevel& finest = cut.levels[0];
        if (i < 0 || j < 0 || (i >> 9) >= finest.columns || (j >> 9) >= finest.rows) return {};
        for (int level = cut.rootLevel; level >= 0; --level) {
            const DirectoryLevel& l = cut.levels[level];
            const Square& s =
                cut.squares[l.offset + static_cast<uint64_t>(j >> (9 + level)) * l.columns +
                            static_cast<uint64_t>(i >> (9 + level))];
            if (s.state == kSquareDrawn) return {s.slot, level};
            if (s.state != kSquareDescend) return {};
        }
        return {};
    }

    /// True if the terrain's rectangle ends exactly where this cell begins, or before.
    bool isBeyond(int64_t column, int64_t row) const {
        int64_t i = axes.transposed ? row : column, j = axes.transposed ? column : row;
        if (axes.mirroredX) i = -i - 1;
        if (axes.mirroredY) j = -j - 1;
        return i < 0 || j < 0 || i >= cut.cellsX || j >= cut.cellsY;
    }

private:
    int64_t inside(const TileDesc& tile, bool y) const {
        const Span span = along(tile, y);
        return (y ? axes.mirroredY : axes.mirroredX) ? span.end - 1 : span.begin;
    }
    Span along(const TileDesc& tile, bool y) const {
        const int64_t size = int64_t{kSlotCells} << (tile.mipFlags & kTileMipMask);
        const int64_t first = y ? tile.y : tile.x;
        return (y ? axes.mirroredY : axes.mirroredX) ? Span{-(first + size), -first}
                                                     : Span{first, first + size};
    }
};

}  // namespace

std::vector<uint32_t> drawnSlots(const TerrainCut& cut) {
    std::vector<uint32_t> slots;
    addDrawn(cut, cut.rootLevel, 0, 0, slots);
    return slots;
}

/// Fills a SunSweep. confined.
class SunSweeper {
public:
    SunSweeper(const TerrainCut& cut, SunSweep& sweep)
        : cut_(cut), sweep_(sweep), lattice_{cut, sweep.axes_} {}

    void run() {
        prepare();
        std::vector<uint32_t> ready;
        for (uint32_t n = 0; n < tiles_.size(); ++n)
            if (waits_[n].load() == 0) ready.push_back(n);
        oneapi::tbb::parallel_for_each(ready, [this](uint32_t n, auto& feeder) {
            sweepOne(n);
            for (const uint32_t next : tiles_[n].behind)
                if (waits_[next].fetch_sub(1) == 1) feeder.add(next);
        });
    }

private:
    struct Tile {
        TileToSweep shape;
        int mip = 0;
        SunLattice::Span columns{}, rows{};
        std::vector<uint32_t> behind;  ///< tiles that this one hands on to
        TileOutflow outflow;
    };

    void prepare();
    void place(uint32_t n);
    uint32_t neighbour(const Tile& tile, int64_t column, int64_t row) const;
    void describe(uint32_t n);
    template <class Use>
    void eachAhead(const Tile& tile, bool far, const Use& use) const;
    void collect(const Tile& tile, bool far, BorderBounds& bounds) const;
    void sweepOne(uint32_t n);

    const TerrainCut& cut_;
    SunSweep& sweep_;
    SunLattice lattice_;
    HeightScale scale_;
    double perRow_ = 1;  ///< t from row to row of mip 0
    std::vector<Tile> tiles_;
    std::vector<uint32_t> indexOf_;  ///< per slot
    std::unique_ptr<std::atomic<int>[]> waits_;
};

/// Calls use(tile index, first cell, end cell) for the tiles beyond the far row or far column, with
/// the cells of the border (mip-0, absolute) that they share.
template <class Use>
void SunSweeper::eachAhead(const Tile& tile, bool far, const Use& use) const {
    const SunLattice::Span along = far ? tile.columns : tile.rows;
    const int64_t beyond = far ? tile.rows.end : tile.columns.end;
    for (int64_t at = along.begin; at < along.end;) {
        const auto found = far ? lattice_.at(at, beyond) : lattice_.at(beyond, at);
        if (found.slot == kNoSlot) {
            // Nothing drawn here: squares of mip 0 are the smallest.
            at = (at - along.begin) / kSlotCells * kSlotCells + kSlotCells + along.begin;
            continue;
        }
        const uint32_t n = indexOf_[found.slot];
        const int64_t end = far ? tiles_[n].columns.end : tiles_[n].rows.end;
        use(n, at, std::min(end, along.end));
        at = end;
    }
}

/// What comes in through the far row or the far column, per cell of the tile.
void SunSweeper::collect(const Tile& tile, bool far, BorderBounds& bounds) const {
    const int64_t begin = far ? tile.columns.begin : tile.rows.begin;
    const int64_t unit = int64_t{1} << tile.mip;
    std::array<bool, kSlotCells> seen{};
    bounds.free.fill(-kInfinity);
    bounds.caught.fill(-kInfinity);
    eachAhead(tile, far, [&](uint32_t n, int64_t first, int64_t end) {
        const Tile& ahead = tiles_[n];
        const BorderBounds& from = far ? ahead.outflow.near : ahead.outflow.side;
        const int64_t origin = far ? ahead.columns.begin : ahead.rows.begin;
        const int64_t finer = std::min(unit, int64_t{1} << ahead.mip);
        for (int64_t at = first; at < end; at += finer) {
            const auto to = static_cast<size_t>((at - begin) >> tile.mip);
            const auto source = static_cast<size_t>((at - origin) >> ahead.mip);
            bounds.free[to] = std::max(bounds.free[to], from.free[source]);
            bounds.caught[to] =
                seen[to] ? std::min(bounds.caught[to], from.caught[source]) : from.caught[source];
            seen[to] = true;
        }
    });
}

void SunSweeper::sweepOne(uint32_t n) {
    Tile& tile = tiles_[n];
    TileInflow inflow;
    collect(tile, true, inflow.far);
    collect(tile, false, inflow.side);
    sweepTile(cut_, sweep_.axes_, scale_, tile.shape, inflow, tile.outflow,
              sweep_.entries_.get() + uint64_t{kSweepEntries} * n);
}

/// Where a tile lies and how rays sink over it.
void SunSweeper::place(uint32_t n) {
    const uint32_t slot = sweep_.drawn_[n];
    const TileDesc& desc = cut_.tiles[slot];
    Tile& tile = tiles_[n];
    indexOf_[slot] = n;
    tile.mip = mipOf(cut_, slot);
    tile.columns = lattice_.alongColumns(desc);
    tile.rows = lattice_.alongRows(desc);
    const double size = std::ldexp(1.0, tile.mip);
    const SunAxes& axes = sweep_.axes_;
    TileToSweep& shape = tile.shape;
    shape.desc = &desc;
    const auto rim = [&](int cells, int first, bool mirrored, double& end, int& low, int& high) {
        const double inside = std::min((cells - first) / size, double{kSlotCells});
        const int posts = static_cast<int>(std::ceil(inside));
        end = mirrored ? kSlotCells : inside;
        low = mirrored ? kSlotCells - posts : 0;
        high = mirrored ? kSlotCells : posts;
    };
    rim(cut_.cellsX, desc.x, axes.mirroredX, axes.transposed ? shape.rowsEnd : shape.columnsEnd,
        axes.transposed ? shape.firstRow : shape.firstColumn,
        axes.transposed ? shape.lastRow : shape.lastColumn);
    rim(cut_.cellsY, desc.y, axes.mirroredY, axes.transposed ? shape.columnsEnd : shape.rowsEnd,
        axes.transposed ? shape.firstColumn : shape.firstRow,
        axes.transposed ? shape.lastColumn : shape.lastRow);
    const SunDirection& sun = sweep_.sun_;
    const double t = perRow_ * size;
    const double i0 = desc.x + (axes.mirroredX ? kSlotCells * size : 0);
    const double j0 = desc.y + (axes.mirroredY ? kSlotCells * size : 0);
    const double perI = sun.riseI * size * (axes.mirroredX ? -1 : 1) * t;
    const double perJ = sun.riseJ * size * (axes.mirroredY ? -1 : 1) * t;
    shape.drop = (sun.slopeAt(i0, j0) + sun.bend * t) * t;
    shape.dropPerColumn = axes.transposed ? perJ : perI;
    shape.dropPerRow = axes.transposed ? perI : perJ;
    shape.slack = sweep_.slopeTolerance_ * t;
    shape.arc = sun.bend * t * t;
}

/// Who goes on at a cell (mip-0, the sun's axes) beyond a tile.
uint32_t SunSweeper::neighbour(const Tile& tile, int64_t column, int64_t row) const {
    if (lattice_.isBeyond(column, row)) return kBeyondTerrain;
    const auto found = lattice_.at(column, row);
    return found.slot != kNoSlot && found.level == tile.mip ? found.slot : kUnlikeTile;
}

/// What the lanes need to know of a tile.
void SunSweeper::describe(uint32_t n) {
    const uint32_t slot = sweep_.drawn_[n];
    const TileDesc& desc = cut_.tiles[slot];
    const Tile& tile = tiles_[n];
    SweptTile& swept = sweep_.tiles_[slot];
    swept.posts =
        cut_.format == 0
            ? static_cast<const void*>(static_cast<const uint16_t*>(cut_.posts) + desc.posts)
            : static_cast<const float*>(cut_.posts) + desc.posts;
    swept.entries = sweep_.entries_.get() + uint64_t{kSweepEntries} * n;
    // A terrain that ends inside a cell of a coarse tile is left to casting.
    const auto isWhole = [](double cells) { return cells == std::floor(cells); };
    if (isWhole(tile.shape.rowsEnd))
        swept.ahead = neighbour(tile, lattice_.columnInside(desc), tile.rows.end);
    if (isWhole(tile.shape.columnsEnd))
        swept.aside = neighbour(tile, tile.columns.end, lattice_.rowInside(desc));
    swept.postsZ = cut_.format == 0 ? desc.z0 - scale_.anchorZ : -scale_.anchorZ;
    swept.postsStep = desc.zStep;
    swept.perRow = static_cast<float>(std::ldexp(perRow_, tile.mip));
    swept.columns = static_cast<int32_t>(std::floor(tile.shape.columnsEnd));
    swept.rows = static_cast<int32_t>(std::floor(tile.shape.rowsEnd));
    const double t = perRow_ * std::ldexp(1.0, tile.mip);
    swept.rise = static_cast<float>(tile.shape.drop - sweep_.sun_.bend * t * t);
    swept.risePerColumn = static_cast<float>(tile.shape.dropPerColumn);
    swept.risePerRow = static_cast<float>(tile.shape.dropPerRow);
    // Heights: their roundings relative to the anchor, and of 16-bit posts to float. Places: a walk
    // errs by less than 5e-7 cells a row, on either side of an edge.
    const float far = std::max(std::fabs(cut_.minZ), std::fabs(cut_.maxZ));
    const float rounding =
        simd::kFloatError * scale_.reach + (cut_.format == 0 ? 1.2e-7f * far : 0.0f);
    swept.error = 6.0f * rounding + 2e-6f * desc.maxDelta;
    swept.errorPerRow = 1e-6f * desc.maxDelta;
}

void SunSweeper::prepare() {
    const auto& drawn = sweep_.drawn_;
    const SunDirection& sun = sweep_.sun_;
    perRow_ = 1 / std::fabs(sweep_.axes_.transposed ? sun.dx : sun.dy);
    scale_.anchorZ = 0.5f * (cut_.minZ + cut_.maxZ);
    float reach = 0.5f * (cut_.maxZ - cut_.minZ);
    for (const uint32_t slot : drawn)
        if (cut_.format == 0)
            reach = std::max(reach, std::fabs(cut_.tiles[slot].z0 - scale_.anchorZ));
    scale_.reach = reach + 1e-3f;
    const float half = 0.51f * (cut_.maxZ - cut_.minZ) + 1e-6f * scale_.reach + 1e-4f;
    scale_.codeZ = -half;
    sweep_.anchorZ_ = scale_.anchorZ;
    sweep_.codeZ_ = -half;
    sweep_.codeStep_ = 2 * half / 65000.0f;
    scale_.codesPerMetre = 1 / sweep_.codeStep_;
    tiles_ = std::vector<Tile>(drawn.size());
    indexOf_.assign(cut_.tileCount, 0);
    waits_ = std::make_unique<std::atomic<int>[]>(drawn.size());
    sweep_.tiles_.resize(cut_.tileCount);
    sweep_.entries_ = SunSweep::allocate(kSweepEntries * drawn.size());
    for (uint32_t n = 0; n < drawn.size(); ++n) place(n);
    for (uint32_t n = 0; n < drawn.size(); ++n) {
        describe(n);
        for (const bool far : {true, false})
            eachAhead(tiles_[n], far, [&](uint32_t ahead, int64_t, int64_t) {
                tiles_[ahead].behind.push_back(n);
                ++waits_[n];
            });
    }
}

/// On huge pages, which lanes that read all over it need as much as for the posts. Its end is not
/// rounded up.
std::unique_ptr<uint32_t[], SunSweep::Free> SunSweep::allocate(size_t count) {
    constexpr size_t kHugePage = size_t{2} << 20;
    const size_t bytes = count * sizeof(uint32_t);
    void* memory = nullptr;
    if (posix_memalign(&memory, kHugePage, bytes) != 0) throw std::bad_alloc();
    madvise(memory, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);
    return std::unique_ptr<uint32_t[], Free>(static_cast<uint32_t*>(memory));
}

std::shared_ptr<const SunSweep> SunSweep::make(const TerrainCut& cut, const SunDirection& sun) {
    const bool overhead =
        std::max(std::fabs(sun.dx), std::fabs(sun.dy)) < 1e-9 * std::fabs(sun.rise);
    if (overhead || cut.surface != kSurfaceBilinear || sun.bend < 0) return nullptr;
    // A cell of a border must not reach over two squares of the directory.
    if (cut.rootLevel > kTileLevels) return nullptr;
    double least = std::numeric_limits<double>::infinity(), greatest = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const double slope = sun.slopeAt((corner & 1) * cut.cellsX, (corner >> 1) * cut.cellsY);
        least = std::min(least, slope);
        greatest = std::max(greatest, slope);
    }
    if (!(least > 0)) return nullptr;
    std::shared_ptr<SunSweep> sweep(new SunSweep);
    sweep->sun_ = sun;
    sweep->axes_ = axesOf(sun);
    sweep->posts_ = cut.posts;
    sweep->drawn_ = drawnSlots(cut);
    sweep->slopeTolerance_ = 1e-9 * greatest;
    if (sweep->drawn_.empty() || sweep->bytes() > (uint64_t{4} << 30)) return nullptr;
    SunSweeper(cut, *sweep).run();
    return sweep;
}

bool SunSweep::fits(const TerrainCut& cut, const SunDirection& sun) const {
    return sun == sun_ && cut.posts == posts_ && cut.surface == kSurfaceBilinear &&
           drawnSlots(cut) == drawn_;
}

SunSweep::Bounds SunSweep::boundsAt(uint32_t slot, int row, double column) const {
    const auto shear = static_cast<float>(axes_.shear);
    const auto r = static_cast<float>(row);
    const float strip = std::floor(static_cast<float>(column) - shear * r) - firstStrip(shear, r);
    const uint32_t entry =
        tiles_[slot].entries[(row / kSweepStep - 1) * kSweepStride + static_cast<int>(strip)];
    const double zero = static_cast<double>(anchorZ_) + static_cast<double>(codeZ_);
    const uint32_t up = entry >> 16, down = entry & 0xFFFFu;
    const double none = std::numeric_limits<double>::infinity();
    return {up == kUnknownFree ? none : zero + up * static_cast<double>(codeStep_),
            down == 0 ? -none : zero + down * static_cast<double>(codeStep_)};
}

}  // namespace terray
