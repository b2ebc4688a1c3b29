// SPDX-License-Identifier: Apache-2.0
// Building hand-made cuts, straight from the words of docs/surface.md.
#include "kernel/test_cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "kernel/pyramid.h"

namespace terray::test {
namespace {

constexpr int kCells = 512;
int tilesAcross(int posts) { return std::max(1, (posts - 2) / kCells + 1); }

}  // namespace

Heights::Heights(int columnCount, int rowCount, const std::function<double(int, int)>& height)
    : columns(columnCount), rows(rowCount) {
    z.resize(static_cast<size_t>(columns) * static_cast<size_t>(rows));
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) at(i, j) = static_cast<float>(height(i, j));
}

Heights coarserHeights(const Heights& fine) {
    const auto mean = [&fine](int i, int j) {
        const int ci = std::min(2 * i, fine.columns - 1), cj = std::min(2 * j, fine.rows - 1);
        if (!std::isfinite(fine.at(ci, cj))) return std::numeric_limits<double>::quiet_NaN();
        double sum = 0, weights = 0;
        for (int dj = -1; dj <= 1; ++dj)
            for (int di = -1; di <= 1; ++di) {
                const float z = fine.at(std::clamp(ci + di, 0, fine.columns - 1),
                                        std::clamp(cj + dj, 0, fine.rows - 1));
                const double weight = (2 - std::abs(di)) * (2 - std::abs(dj));
                if (!std::isfinite(z)) continue;
                sum += weight * static_cast<double>(z);
                weights += weight;
            }
        return sum / weights;
    };
    return Heights(fine.columns / 2 + 1, fine.rows / 2 + 1, mean);
}

TestCut::TestCut(const Heights& heights, const CutChoice& choice) {
    layOutLevels(heights);
    encode(heights, choice);
    Heights posts = heights;
    uint32_t slot = 0;
    for (int mip = 0; mip <= cut_.rootLevel; ++mip) {
        const DirectoryLevel& level = cut_.levels[mip];
        for (uint32_t y = 0; y < level.rows; ++y)
            for (uint32_t x = 0; x < level.columns; ++x, ++slot)
                fillTile(posts, mip, static_cast<int>(x), static_cast<int>(y), slot);
        posts = coarserHeights(posts);
    }
    cut_.tiles = tiles_.data();
    cut_.posts = choice.int16 ? static_cast<const void*>(codes_.data()) : floatPosts_.data();
    cut_.bounds = bounds_.data();
    cut_.squares = squares_.data();
    cut_.surface = choice.surface;
    cut_.minZ = std::numeric_limits<float>::infinity();
    cut_.maxZ = -cut_.minZ;
    drawSquares(cut_.rootLevel, 0, 0, choice);
}

void TestCut::layOutLevels(const Heights& heights) {
    cut_.cellsX = heights.columns - 1;
    cut_.cellsY = heights.rows - 1;
    uint32_t count = 0;
    int columns = heights.columns, rows = heights.rows;
    for (int mip = 0;; ++mip) {
        DirectoryLevel& level = cut_.levels[mip];
        level = {count, static_cast<uint32_t>(tilesAcross(columns)),
                 static_cast<uint32_t>(tilesAcross(rows))};
        count += level.columns * level.rows;
        cut_.rootLevel = mip;
        if (level.columns == 1 && level.rows == 1) break;
        columns = columns / 2 + 1;
        rows = rows / 2 + 1;
    }
    cut_.tileCount = count;
    tiles_.resize(count);
    bounds_.resize(size_t{kSlotBounds} * count);
    squares_.assign(count, Square{0, 0, kNoSlot, kSquareEmpty});
}

void TestCut::encode(const Heights& heights, const CutChoice& choice) {
    const size_t size = size_t{kSlotPosts} * cut_.tileCount;
    if (!choice.int16) {
        cut_.format = 1;
        floatPosts_.resize(size, std::numeric_limits<float>::quiet_NaN());
        return;
    }
    codes_.resize(size, 0xFFFF);
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (const float z : heights.z) {
        if (!std::isfinite(z)) continue;
        low = std::min(low, z);
        high = std::max(high, z);
    }
    z0_ = low;
    zStep_ = static_cast<float>(choice.zStep);
    if (choice.zStep == 0) zStep_ = high > low ? (high - low) / 65534.0f : 1.0f;
}

void TestCut::fillTile(const Heights& posts, int mip, int x, int y, uint32_t slot) {
    TileDesc& tile = tiles_[slot];
    tile.posts = uint64_t{kSlotPosts} * slot;
    tile.bounds = uint64_t{kSlotBounds} * slot;
    tile.x = x * kCells << mip;
    tile.y = y * kCells << mip;
    tile.z0 = z0_;
    tile.zStep = zStep_;
    tile.mipFlags = static_cast<uint32_t>(mip);
    for (int j = 0; j <= kCells; ++j)
        for (int i = 0; i <= kCells; ++i) {
            const float z = posts.at(std::min(x * kCells + i, posts.columns - 1),
                                     std::min(y * kCells + j, posts.rows - 1));
            const size_t at = tile.posts + static_cast<size_t>(j * kPostStride + i);
            if (cut_.format == 1)
                floatPosts_[at] = z;
            else if (std::isfinite(z))
                codes_[at] =
                    static_cast<uint16_t>(std::clamp(std::lround((z - z0_) / zStep_), 0L, 65534L));
        }
    const int cellsX = std::min(kCells, posts.columns - 1 - x * kCells);
    const int cellsY = std::min(kCells, posts.rows - 1 - y * kCells);
    uint32_t* bounds = bounds_.data() + tile.bounds;
    const SlotBounds made =
        cut_.format == 1
            ? buildPyramid(floatPosts_.data() + tile.posts, cellsX, cellsY, tile, bounds)
            : buildPyramid(codes_.data() + tile.posts, cellsX, cellsY, tile, bounds);
    square(mip, static_cast<uint32_t>(x), static_cast<uint32_t>(y)) =
        Square{made.minZ, made.maxZ, slot, kSquareCovered};
}

int TestCut::wantedMip(int level, int x, int y, const CutChoice& choice) const {
    const DirectoryLevel& finest = cut_.levels[0];
    int wanted = level;
    for (int j = y << level; j < (y + 1) << level && j < static_cast<int>(finest.rows); ++j)
        for (int i = x << level; i < (x + 1) << level && i < static_cast<int>(finest.columns); ++i)
            wanted = std::min(wanted, choice.mipOfTile(i, j));
    return wanted;
}

/// Sets the state of a square and of all below it; false if there is nothing to hit.
bool TestCut::drawSquares(int level, int x, int y, const CutChoice& choice) {
    const DirectoryLevel& directory = cut_.levels[level];
    if (x >= static_cast<int>(directory.columns) || y >= static_cast<int>(directory.rows))
        return false;
    Square& here = square(level, static_cast<uint32_t>(x), static_cast<uint32_t>(y));
    if (wantedMip(level, x, y, choice) == level) {
        here.state = here.minZ <= here.maxZ ? kSquareDrawn : kSquareEmpty;
        if (here.state == kSquareEmpty) return false;
        cut_.minZ = std::min(cut_.minZ, here.minZ);
        cut_.maxZ = std::max(cut_.maxZ, here.maxZ);
        cut_.maxDelta = std::max(cut_.maxDelta, tiles_[here.slot].maxDelta);
        return true;
    }
    here.minZ = std::numeric_limits<float>::infinity();
    here.maxZ = -here.minZ;
    here.state = kSquareEmpty;
    for (int k = 0; k < 4; ++k) {
        const int cx = 2 * x + (k & 1), cy = 2 * y + (k >> 1);
        if (!drawSquares(level - 1, cx, cy, choice)) continue;
        const Square& child =
            square(level - 1, static_cast<uint32_t>(cx), static_cast<uint32_t>(cy));
        here.state = kSquareDescend;
        here.minZ = std::min(here.minZ, child.minZ);
        here.maxZ = std::max(here.maxZ, child.maxZ);
    }
    return here.state == kSquareDescend;
}

uint32_t TestCut::slotOf(int mip, int x, int y) const {
    const DirectoryLevel& level = cut_.levels[mip];
    return level.offset + static_cast<uint32_t>(y) * level.columns + static_cast<uint32_t>(x);
}

Square& TestCut::square(int level, uint32_t x, uint32_t y) {
    const DirectoryLevel& directory = cut_.levels[level];
    return squares_[directory.offset + y * directory.columns + x];
}

// ---- Terrains ----------------------------------------------------------------------------------

Heights roughTerrain(int columns, int rows, double amplitude, uint32_t seed) {
    const auto hash = [seed](int i, int j, int octave) {
        uint64_t h = static_cast<uint64_t>(seed) * 0x9E3779B97F4A7C15u +
                     static_cast<uint64_t>(static_cast<uint32_t>(i)) * 0xBF58476D1CE4E5B9u +
                     static_cast<uint64_t>(static_cast<uint32_t>(j)) * 0x94D049BB133111EBu +
                     static_cast<uint64_t>(octave) * 0xD6E8FEB86659FD93u;
        h = (h ^ (h >> 31)) * 0xBF58476D1CE4E5B9u;
        h = (h ^ (h >> 29)) * 0x94D049BB133111EBu;
        return static_cast<double>((h ^ (h >> 32)) >> 11) * 0x1p-53;
    };
    const auto height = [&](int i, int j) {
        double sum = 0, weight = 0.5 * amplitude;
        for (int octave = 7; octave >= 0; --octave, weight *= 0.55) {
            const int x = i >> octave, y = j >> octave;
            const double u = std::ldexp(i - (x << octave), -octave);
            const double v = std::ldexp(j - (y << octave), -octave);
            const double top = hash(x, y, octave) * (1 - u) + hash(x + 1, y, octave) * u;
            const double bottom = hash(x, y + 1, octave) * (1 - u) + hash(x + 1, y + 1, octave) * u;
            sum += weight * (top * (1 - v) + bottom * v);
        }
        return sum;
    };
    return Heights(columns, rows, height);
}

Heights townTerrain(int columns, int rows, double step, uint32_t seed) {
    Heights town(columns, rows,
                 [](int i, int j) { return 10 + 0.02 * i + 3 * std::sin(0.013 * j); });
    std::mt19937 random(seed);
    for (int house = 0; house < columns * rows / 150; ++house) {
        const int x = static_cast<int>(random() % static_cast<uint32_t>(columns));
        const int y = static_cast<int>(random() % static_cast<uint32_t>(rows));
        const int width = 1 + static_cast<int>(random() % 9),
                  depth = 1 + static_cast<int>(random() % 9);
        const auto roof = static_cast<float>(step * (0.2 + static_cast<double>(random() % 5) / 5));
        for (int j = y; j < std::min(y + depth, rows); ++j)
            for (int i = x; i < std::min(x + width, columns); ++i) town.at(i, j) = 12 + roof;
    }
    return town;
}

void punchHoles(Heights& heights, int count, uint32_t seed) {
    std::mt19937 random(seed);
    for (int hole = 0; hole < count; ++hole) {
        const int x = static_cast<int>(random() % static_cast<uint32_t>(heights.columns));
        const int y = static_cast<int>(random() % static_cast<uint32_t>(heights.rows));
        const int side = hole % 8 == 0 ? 12 : 1;
        for (int j = y; j < std::min(y + side, heights.rows); ++j)
            for (int i = x; i < std::min(x + side, heights.columns); ++i)
                heights.at(i, j) = std::numeric_limits<float>::quiet_NaN();
    }
}

}  // namespace terray::test
