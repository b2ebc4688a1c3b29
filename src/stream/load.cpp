// SPDX-License-Identifier: Apache-2.0
// Reading a source in bands of rows on all cores, scattered into tile slots.
#include "stream/load.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>

#include "base/progress.h"
#include "base/simd_clones.h"
#include "base/workers.h"

namespace terray {
namespace {

constexpr int64_t kBandBytes = int64_t{1} << 20;  ///< read at once, per reader
constexpr int64_t kLeastRows = 64;                ///< of a task

template <class Post>
struct Tally {
    uint64_t holes = 0;
    Post low = std::numeric_limits<Post>::max(), high = std::numeric_limits<Post>::lowest();
    void add(const Tally& other) {
        holes += other.holes;
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
};

TERRAY_SIMD_CLONES
Tally<uint16_t> tally(uint16_t* codes, int64_t count) {
    constexpr int64_t kPart = 1 << 15;  // 16-bit sums cannot overflow within it
    Tally<uint16_t> sum;
    for (int64_t start = 0; start < count; start += kPart) {
        const int part = static_cast<int>(std::min(kPart, count - start));
        const uint16_t* from = codes + start;
        uint16_t holes = 0, low = 0xFFFF, high = 0;
        for (int k = 0; k < part; ++k) {
            const uint16_t code = from[k];
            const uint16_t hole = code == kHolePost ? uint16_t{0xFFFF} : uint16_t{0};
            holes = static_cast<uint16_t>(holes - hole);
            low = std::min(low, code);
            high = std::max(high, static_cast<uint16_t>(code & ~hole));
        }
        sum.add({holes, low, high});
    }
    return sum;
}

/// Also turns infinities into holes, so that nothing later meets one.
TERRAY_SIMD_CLONES
Tally<float> tally(float* heights, int64_t count) {
    constexpr int kLanes = 64;
    constexpr float infinity = std::numeric_limits<float>::infinity();
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    float low[kLanes], high[kLanes];
    uint32_t holes[kLanes] = {};
    std::fill(low, low + kLanes, infinity);
    std::fill(high, high + kLanes, -infinity);
    for (int64_t start = 0; start < count; start += kLanes) {
        const int lanes = static_cast<int>(std::min<int64_t>(kLanes, count - start));
        float* z = heights + start;
        for (int k = 0; k < lanes; ++k) {
            const bool known = std::fabs(z[k]) < infinity;
            z[k] = known ? z[k] : nan;
            holes[k] += known ? 0u : 1u;
            low[k] = z[k] < low[k] ? z[k] : low[k];
            high[k] = z[k] > high[k] ? z[k] : high[k];
        }
    }
    Tally<float> sum;
    for (int k = 0; k < kLanes; ++k) sum.add({holes[k], low[k], high[k]});
    return sum;
}

Result<void> readRows(HeightReader& reader, int64_t row, int64_t rows, int64_t columns,
                      std::span<uint16_t> out) {
    return reader.readCodes(0, row, columns, rows, out);
}
Result<void> readRows(HeightReader& reader, int64_t row, int64_t rows, int64_t columns,
                      std::span<float> out) {
    return reader.read(0, row, columns, rows, out);
}

template <class Post>
class Loader {
public:
    Loader(const HeightSource& source, ResidentTerrain::Pool& pool)
        : source_(source), pool_(pool), columns_(pool.scheme.columns), rows_(pool.scheme.rows) {
        const int64_t preferred = std::clamp<int64_t>(source.preferredRows(), 1, rows_);
        rowsPerTask_ = (kLeastRows + preferred - 1) / preferred * preferred;
        const int64_t rowBytes = columns_ * static_cast<int64_t>(sizeof(Post));
        bandRows_ = std::clamp<int64_t>(kBandBytes / rowBytes, 1, rowsPerTask_);
    }

    Result<Tally<Post>> run() {
        Progress progress("Reading", static_cast<double>(rows_));
        const auto makeReader = [&] { return source_.makeReader(); };
        const auto load = [&](std::unique_ptr<HeightReader>& reader, int64_t task) {
            return loadRows(*reader, task * rowsPerTask_,
                            std::min((task + 1) * rowsPerTask_, rows_), progress);
        };
        TERRAY_TRY(forEachTask((rows_ + rowsPerTask_ - 1) / rowsPerTask_, makeReader, load));
        return total_;
    }

private:
    Result<void> loadRows(HeightReader& reader, int64_t from, int64_t to, Progress& progress) {
        std::vector<Post> band(static_cast<size_t>(columns_ * std::min(bandRows_, to - from)));
        Tally<Post> sum;
        for (int64_t row = from; row < to; row += bandRows_) {
            const int64_t count = std::min(bandRows_, to - row);
            const std::span<Post> posts(band.data(), static_cast<size_t>(columns_ * count));
            TERRAY_TRY(readRows(reader, row, count, columns_, posts));
            sum.add(tally(posts.data(), columns_ * count));
            for (int64_t r = 0; r < count; ++r) scatter(row + r, posts.data() + r * columns_);
            progress.advance(static_cast<double>(count));
            if (isInterrupted()) return Error{ErrorCode::Interrupted, "interrupted"};
        }
        const std::lock_guard lock(mutex_);
        total_.add(sum);
        return {};
    }

    /// A row on the border of two rows of tiles belongs to both.
    void scatter(int64_t row, const Post* posts) {
        const int y = static_cast<int>(row >> kTileCellsLog2);
        const int local = static_cast<int>(row & (kTileCells - 1));
        if (y < pool_.scheme.tilesY(0)) scatterInto(y, local, posts);
        if (local == 0 && y > 0) scatterInto(y - 1, kTileCells, posts);
    }
    void scatterInto(int y, int local, const Post* posts) {
        for (int x = 0; x < pool_.scheme.tilesX(0); ++x) {
            const TileId id{0, x, y};
            Post* to = pool_.template postsOf<Post>(pool_.slotOf(id)) +
                       static_cast<ptrdiff_t>(local) * kPostStride;
            std::copy_n(posts + int64_t{x} * kTileCells, pool_.cellsX(id) + 1, to);
        }
    }

    const HeightSource& source_;
    ResidentTerrain::Pool& pool_;
    int64_t columns_, rows_, rowsPerTask_ = 1, bandRows_ = 1;
    std::mutex mutex_;
    Tally<Post> total_;
};

}  // namespace

Result<void> loadTiles(const TileSource& source, ResidentTerrain::Pool& pool) {
    Progress progress("Reading", static_cast<double>(pool.tiles.size()));
    const auto makeReader = [&] { return source.makeReader(); };
    const auto load = [&](std::unique_ptr<TileReader>& reader, int64_t task) -> Result<void> {
        const auto slot = static_cast<uint32_t>(task);
        const TileId id = pool.ids[slot];
        progress.advance();
        return pool.format == PostFormat::Int16
                   ? reader->readCodes(id, pool.postsOf<uint16_t>(slot), kPostStride)
                   : reader->read(id, pool.postsOf<float>(slot), kPostStride);
    };
    return forEachTask(static_cast<int64_t>(pool.tiles.size()), makeReader, load);
}

Result<LoadSummary> loadFinest(const HeightSource& source, ResidentTerrain::Pool& pool) {
    LoadSummary summary;
    if (pool.format == PostFormat::Float32) {
        auto sum = Loader<float>(source, pool).run();
        if (!sum) return sum.error();
        summary.holes = sum->holes;
        if (sum->low <= sum->high) {
            summary.minZ = sum->low;
            summary.maxZ = sum->high;
        }
        return summary;
    }
    auto sum = Loader<uint16_t>(source, pool).run();
    if (!sum) return sum.error();
    summary.holes = sum->holes;
    if (sum->low <= sum->high) {
        const TerrainInfo& info = source.info();
        summary.minZ = std::fma(info.zStep, static_cast<float>(sum->low), info.z0);
        summary.maxZ = std::fma(info.zStep, static_cast<float>(sum->high), info.z0);
    }
    return summary;
}

}  // namespace terray
