// SPDX-License-Identifier: Apache-2.0
// Tiles through the codec, and bounds from theory.
#include "terabyte_source.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "base/stopwatch.h"
#include "store/edges.h"
#include "store/shard_codec.h"

namespace terray::bench {
namespace {

constexpr int kSquareLog2 = 6;      ///< metres, of the clutter's squares
constexpr double kRounding = 0.05;  ///< metres: of heights to their step, and of float sums
constexpr int kBlockLog2 = 6;       ///< cells of a block
constexpr double kDiagonal = 1.4142136;

/// A tile as a terrain of its own, for the codec.
TerrainInfo tileInfo(const TerrainInfo& info, int width, int height) {
    TerrainInfo tile;
    tile.scheme = {std::max(width, 2), std::max(height, 2)};
    tile.worldFromLattice = info.worldFromLattice;
    tile.format = PostFormat::Float32;
    return tile;
}

/// confined.
class TerabyteReader final : public TileReader {
public:
    explicit TerabyteReader(const TerabyteSource& source)
        : source_(source),
          made_(size_t{kTilePosts} * kTilePosts),
          block_(size_t{kBlockPosts} * kBlockPosts) {}

    Result<void> read(TileId id, float* posts, ptrdiff_t stride) override {
        const TilingScheme& scheme = source_.info().scheme;
        const int width = scheme.cellsX(id) + 1, height = scheme.cellsY(id) + 1;
        const CpuStopwatch making;
        source_.makePosts(id.mip, int64_t{id.x} * kTileCells, int64_t{id.y} * kTileCells, width,
                          height, made_.data());
        const double makeMs = making.elapsedMs();
        const CpuStopwatch encoding;
        const TerrainInfo info =
            tileInfo(source_.info(), std::min(width, kBlockPosts), std::min(height, kBlockPosts));
        const auto file = encodeShard(info, HeightCodec{}, ShardId{}, made_.data(), width);
        if (!file) return file.error();
        const double encodeMs = encoding.elapsedMs();
        const CpuStopwatch decoding;
        auto shard = ShardFile::open(*file, info, ShardId{});
        if (!shard) return shard.error();
        TERRAY_TRY((*shard)->read(0, block_.data()));
        fill(posts, stride, width, height);
        TerabyteSource::Work& work = source_.work();
        ++work.tiles;
        work.encodedBytes += file->bytes.size() + kEdgePosts * sizeof(float);
        work.decodedBytes +=
            static_cast<uint64_t>(width) * static_cast<uint64_t>(height) * sizeof(float);
        work.makeMs += makeMs;
        work.encodeMs += encodeMs;
        work.decodeMs += decoding.elapsedMs();
        return {};
    }
    Result<void> readCodes(TileId, uint16_t*, ptrdiff_t) override {
        return makeError(ErrorCode::Usage, "the terabyte has floats");
    }

private:
    /// Edges are stored without loss, and so are blocks here: the made ones.
    void fill(float* posts, ptrdiff_t stride, int width, int height) const {
        for (int row = 0; row < height; ++row) {
            float* const out = posts + row * stride;
            const float* const made = made_.data() + int64_t{row} * width;
            const int inBlock = row < kBlockPosts ? std::min(width, kBlockPosts) : 0;
            std::copy_n(block_.data() + int64_t{std::min(row, kBlockPosts - 1)} * kBlockPosts,
                        inBlock, out);
            std::copy(made + inBlock, made + width, out + inBlock);
        }
    }

    const TerabyteSource& source_;
    std::vector<float> made_, block_;
};

/// Least and greatest values of squares.
struct Range {
    float low = INFINITY, high = -INFINITY;
    void add(const Range& other) {
        low = std::min(low, other.low);
        high = std::max(high, other.high);
    }
};

struct RangeGrid {
    int64_t width = 0, height = 0;
    std::vector<Range> ranges;
    /// Of places outside the nearest inside.
    const Range& at(int64_t x, int64_t y) const {
        x = std::clamp<int64_t>(x, 0, width - 1);
        y = std::clamp<int64_t>(y, 0, height - 1);
        return ranges[static_cast<size_t>(y * width + x)];
    }
};

template <class Make>
RangeGrid makeGrid(int64_t width, int64_t height, const Make& make) {
    RangeGrid grid{width, height, std::vector<Range>(static_cast<size_t>(width * height))};
    tbb::parallel_for(int64_t{0}, height, [&](int64_t y) {
        for (int64_t x = 0; x < width; ++x)
            grid.ranges[static_cast<size_t>(y * width + x)] = make(x, y);
    });
    return grid;
}

RangeGrid halved(const RangeGrid& grid) {
    return makeGrid((grid.width + 1) / 2, (grid.height + 1) / 2, [&](int64_t x, int64_t y) {
        Range range = grid.at(2 * x, 2 * y);
        range.add(grid.at(2 * x + 1, 2 * y));
        range.add(grid.at(2 * x, 2 * y + 1));
        range.add(grid.at(2 * x + 1, 2 * y + 1));
        return range;
    });
}

RangeGrid dilated(const RangeGrid& grid) {
    return makeGrid(grid.width, grid.height, [&](int64_t x, int64_t y) {
        Range range;
        for (int64_t dy = -1; dy <= 1; ++dy)
            for (int64_t dx = -1; dx <= 1; ++dx) range.add(grid.at(x + dx, y + dy));
        return range;
    });
}

}  // namespace

/// Blocks of mip m of the source are the squares of level m + finestMip of the clutter. A coarse
/// post stands at half the height of the square that it is in, so a coarse cell is bounded by its
/// block's squares and those one cell around.
class BoundsMaker {
public:
    explicit BoundsMaker(TerabyteSource& source) : source_(source), finest_(source.finestMip_) {}

    void run() {
        makeSquares();
        const int mips = source_.info_.scheme.mipCount();
        for (int mip = 0; mip <= mips; ++mip) {
            toFinest_.push_back(hillsError(finest_ + mip, finest_) + kRounding);
            toNext_.push_back(hillsError(finest_ + mip + 1, finest_ + mip) + kRounding);
        }
        for (int mip = 0; mip < mips; ++mip) {
            source_.bounds_.emplace_back(static_cast<size_t>(source_.info_.scheme.tileCount(mip)) *
                                         kTileBlocks * kTileBlocks);
            tbb::parallel_for(0, source_.info_.scheme.tilesY(mip) * kTileBlocks, [&](int y) {
                for (int x = 0; x < widthOf(mip); ++x) setErrors(mip, x, y);
            });
            if (mip == 0)
                setFinestHeights();
            else
                inheritHeights(mip);
        }
        Range all;
        const BlockBounds& root = source_.bounds_.back().front();
        all.add({root.minZ, root.maxZ});
        for (const BlockBounds& block : source_.bounds_.back())
            if (block.minZ <= block.maxZ) all.add({block.minZ, block.maxZ});
        source_.info_.minZ = all.low;
        source_.info_.maxZ = all.high;
    }

private:
    int widthOf(int mip) const { return source_.info_.scheme.tilesX(mip) * kTileBlocks; }
    BlockBounds& block(int mip, int64_t x, int64_t y) {
        return source_.bounds_[static_cast<size_t>(mip)][static_cast<size_t>(y * widthOf(mip) + x)];
    }

    /// squares_[level]: of 64 m * 2^level; near_[level]: with what is one coarse cell around, which
    /// is no more than 64 m up to level 6.
    void makeSquares() {
        const Clutter& clutter = source_.clutter_;
        squares_.push_back(
            makeGrid(clutter.squaresX(), clutter.squaresY(), [&](int64_t x, int64_t y) {
                const float z = clutter.heights()[static_cast<size_t>(y * clutter.squaresX() + x)];
                return Range{z, z};
            }));
        near_.push_back(dilated(squares_[0]));
        const int levels = finest_ + source_.info_.scheme.mipCount() + 1;
        for (int level = 1; level < levels; ++level) {
            squares_.push_back(halved(squares_.back()));
            near_.push_back(level <= kSquareLog2 ? halved(near_.back()) : dilated(squares_.back()));
        }
    }

    /// Of mip m to the source's finest.
    double errorOf(int mip, const Range& inside, const Range& near) const {
        if (mip == 0) return 0;
        const double low = static_cast<double>(near.low), high = static_cast<double>(near.high);
        const double clutter = finest_ == 0
                                   ? std::max(high / 2, static_cast<double>(inside.high) - low / 2)
                                   : (high - low) / 2;
        return toFinest_[static_cast<size_t>(mip)] + clutter;
    }

    void setErrors(int mip, int64_t x, int64_t y) {
        const int level = finest_ + mip;
        const auto at = static_cast<size_t>(level);
        const Range &inside = squares_[at].at(x, y), &near = near_[at].at(x, y);
        const double spread = static_cast<double>(near.high - near.low) / 2;
        BlockBounds& out = block(mip, x, y);
        out.errorToFinest = static_cast<float>(errorOf(mip, inside, near));
        const double hills = toNext_[static_cast<size_t>(mip)];
        double next = hills + spread;
        if (mip == 0) next = errorOf(1, inside, near);
        if (mip == 0) next = std::max(next, errorOf(1, inside, near_[at + 1].at(x / 2, y / 2)));
        if (mip + 1 < source_.info_.scheme.mipCount()) {
            const Range& wide = near_[at + 1].at(x / 2, y / 2);
            next = std::max(next, hills + static_cast<double>(wide.high - wide.low) / 2);
            out.errorToNext = static_cast<float>(next);
        }
        const double cell = std::exp2(level), finestCell = std::exp2(finest_);
        const double rise = finest_ == 0 && mip == 0 ? static_cast<double>(near.high) : spread;
        const double finestRise = finest_ == 0 ? static_cast<double>(near.high) : spread;
        out.maxSlope = static_cast<float>(
            kDiagonal * (slope_ + (rise + 2 * static_cast<double>(kHeightStep)) / cell));
        out.cellRange = static_cast<float>(
            std::max(2 * slope_ * cell + rise, 2 * slope_ * finestCell + finestRise) + kRounding);
        out.flags = kBlockFinestHasCells;
        out.minZ = INFINITY;
        out.maxZ = -INFINITY;
    }

    /// Octaves longer than a block at its corners, and what they may do between; the others by
    /// their amplitudes.
    void setFinestHeights() {
        const int level = finest_ + kBlockLog2;
        const TilingScheme& scheme = source_.info_.scheme;
        const int64_t blocksX = (scheme.columns - 1 + kBlockCells - 1) / kBlockCells;
        const int64_t blocksY = (scheme.rows - 1 + kBlockCells - 1) / kBlockCells;
        double between = kRounding;
        for (int k = finest_ == 0 ? 0 : finest_ + 1; k <= kCoarsestOctave; ++k)
            between += amplitude(k) * (k <= level ? 1.0 : std::exp2(2.0 * (level - k)));
        const int width = static_cast<int>(blocksX) + 1;
        constexpr int64_t kRows = 64;
        tbb::parallel_for(int64_t{0}, (blocksY + kRows - 1) / kRows, [&](int64_t part) {
            HillRows hills(level, level + 1, kCoarsestOctave, source_.seed_, 0, width);
            std::vector<float> upper, lower(static_cast<size_t>(width));
            hills.addRow(part * kRows, lower.data());
            for (int64_t y = part * kRows; y < std::min((part + 1) * kRows, blocksY); ++y) {
                upper.swap(lower);
                lower.assign(static_cast<size_t>(width), 0.0f);
                hills.addRow(y + 1, lower.data());
                for (int64_t x = 0; x < blocksX; ++x)
                    setFinestHeight(x, y, upper.data() + x, lower.data() + x, between);
            }
        });
    }

    void setFinestHeight(int64_t x, int64_t y, const float* upper, const float* lower,
                         double between) {
        const auto at = static_cast<size_t>(finest_);
        const Range &inside = squares_[at].at(x, y), &near = near_[at].at(x, y);
        const float low = finest_ == 0 ? 0 : near.low / 2;
        // The last row and column of posts are the next squares'.
        const float high = finest_ == 0 ? std::max(near.high, inside.high) : near.high / 2;
        BlockBounds& out = block(0, x, y);
        const auto corners = {upper[0], upper[1], lower[0], lower[1]};
        out.minZ = std::min(corners) + low - static_cast<float>(between);
        out.maxZ = std::max(corners) + high + static_cast<float>(between);
    }

    /// Within its error of what the finest has there.
    void inheritHeights(int mip) {
        const TilingScheme& scheme = source_.info_.scheme;
        const int finerX = widthOf(mip - 1), finerY = scheme.tilesY(mip - 1) * kTileBlocks;
        tbb::parallel_for(0, scheme.tilesY(mip) * kTileBlocks, [&](int y) {
            for (int x = 0; x < widthOf(mip); ++x) {
                BlockBounds& out = block(mip, x, y);
                Range finest;
                for (int child = 0; child < 4; ++child) {
                    const int cx = 2 * x + child % 2, cy = 2 * y + child / 2;
                    if (cx >= finerX || cy >= finerY) continue;
                    const BlockBounds& finer = block(mip - 1, cx, cy);
                    if (finer.minZ > finer.maxZ) continue;
                    finest.add(
                        {finer.minZ + finer.errorToFinest, finer.maxZ - finer.errorToFinest});
                }
                if (finest.low > finest.high) continue;
                out.minZ = finest.low - out.errorToFinest;
                out.maxZ = finest.high + out.errorToFinest;
            }
        });
    }

    TerabyteSource& source_;
    int finest_;
    double slope_ = hillsSlope();
    std::vector<double> toFinest_, toNext_;  ///< of the hills, per mip
    std::vector<RangeGrid> squares_, near_;
};

TerabyteSource::TerabyteSource(int64_t width, int64_t height, int finestMip, uint32_t seed,
                               bool isBare)
    : finestMip_(finestMip), seed_(seed), clutter_(width, height, seed, isBare) {
    const double cell = std::exp2(finestMip);
    info_.name = "terabyte";
    info_.scheme = {(width >> finestMip) + 1, (height >> finestMip) + 1};
    info_.worldFromLattice = {{0, static_cast<double>(height)}, {cell, 0}, {0, -cell}};
    info_.format = PostFormat::Float32;
    BoundsMaker(*this).run();
}

Result<std::unique_ptr<TileReader>> TerabyteSource::makeReader() const {
    return std::unique_ptr<TileReader>(new TerabyteReader(*this));
}

void TerabyteSource::makePosts(int mip, int64_t x, int64_t y, int width, int height,
                               float* out) const {
    const int level = finestMip_ + mip;
    HillRows hills(level, level == 0 ? 0 : level + 1, kCoarsestOctave, seed_, x, width);
    for (int row = 0; row < height; ++row) {
        float* const posts = out + int64_t{row} * width;
        std::fill_n(posts, width, 0.0f);
        hills.addRow(y + row, posts);
        if (level == 0) {
            clutter_.addRow(x, y + row, width, posts);
        } else {
            for (int i = 0; i < width; ++i)
                posts[i] += clutter_.squareHeight((x + i) << level, (y + row) << level) / 2;
        }
        for (int i = 0; i < width; ++i)
            posts[i] = std::nearbyint(posts[i] / kHeightStep) * kHeightStep;
    }
}

}  // namespace terray::bench
