// SPDX-License-Identifier: Apache-2.0
// Every post of a block against its heights; finer posts under a window of it against its errors.
#include "terabyte_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace terray::bench {
namespace {

constexpr int kWindow = 96;  ///< finer cells a side that are compared

int pick(std::mt19937& random, int64_t count) {
    return static_cast<int>(random() % static_cast<uint32_t>(std::max<int64_t>(count, 1)));
}

/// A tile as a reader delivers it, and the bilinear surface over it.
struct TileSurface {
    TileId id;
    std::vector<float> posts = std::vector<float>(size_t{kTilePosts} * kTilePosts);

    double at(int i, int j) const {
        return static_cast<double>(posts[static_cast<size_t>(j * kTilePosts + i)]);
    }
    /// At a post of a finer mip, `shift` mips below.
    double at(const TilingScheme& scheme, int64_t column, int64_t row, int shift) const {
        const int64_t i = column - ((int64_t{id.x} * kTileCells) << shift);
        const int64_t j = row - ((int64_t{id.y} * kTileCells) << shift);
        const int ci = std::min(static_cast<int>(i >> shift), scheme.cellsX(id) - 1);
        const int cj = std::min(static_cast<int>(j >> shift), scheme.cellsY(id) - 1);
        const double u = std::ldexp(static_cast<double>(i), -shift) - ci;
        const double v = std::ldexp(static_cast<double>(j), -shift) - cj;
        return (1 - v) * ((1 - u) * at(ci, cj) + u * at(ci + 1, cj)) +
               v * ((1 - u) * at(ci, cj + 1) + u * at(ci + 1, cj + 1));
    }
};

/// The block that a post is in (of two, the one that begins there).
const BlockBounds& blockAt(const TerabyteSource& source, int mip, int64_t column, int64_t row) {
    const TilingScheme& scheme = source.info().scheme;
    const int64_t i = std::min(column, scheme.columnsAt(mip) - 2);
    const int64_t j = std::min(row, scheme.rowsAt(mip) - 2);
    const TileId id{mip, static_cast<int>(i / kTileCells), static_cast<int>(j / kTileCells)};
    return source.block(id, static_cast<int>(i % kTileCells) / kBlockCells,
                        static_cast<int>(j % kTileCells) / kBlockCells);
}

/// A rectangle of finer posts in the block, at random.
struct Window {
    int64_t column = 0, row = 0;
    int width = 0, height = 0;
};
Window windowIn(const TilingScheme& scheme, TileId id, int bx, int by, int finer,
                std::mt19937& random) {
    const int shift = id.mip - finer;
    const auto side = [&](int64_t first, int64_t cells, int64_t last, int64_t& start) {
        const int64_t begin = first << shift;
        const int64_t left = std::min(std::min<int64_t>(kBlockCells, cells) << shift, last - begin);
        const int64_t span = std::min<int64_t>(kWindow, left);
        start = begin + pick(random, left - span + 1);
        return static_cast<int>(span) + 1;
    };
    Window window;
    window.width =
        side(int64_t{id.x} * kTileCells + bx * kBlockCells, scheme.cellsX(id) - bx * kBlockCells,
             scheme.columnsAt(finer) - 1, window.column);
    window.height =
        side(int64_t{id.y} * kTileCells + by * kBlockCells, scheme.cellsY(id) - by * kBlockCells,
             scheme.rowsAt(finer) - 1, window.row);
    return window;
}

std::string heightFault(const TileSurface& tile, const BlockBounds& bounds, int i0, int j0, int i1,
                        int j1) {
    for (int j = j0; j <= j1; ++j) {
        for (int i = i0; i <= i1; ++i) {
            const double z = tile.at(i, j);
            if (z >= static_cast<double>(bounds.minZ) && z <= static_cast<double>(bounds.maxZ))
                continue;
            return fmt::format("post ({}, {}) of tile ({}, {}) of mip {} is {} m, not {} to {}", i,
                               j, tile.id.x, tile.id.y, tile.id.mip, z, bounds.minZ, bounds.maxZ);
        }
    }
    return {};
}

std::string errorFault(const TerabyteSource& source, const TileSurface& tile,
                       const BlockBounds& bounds, const Window& window, int finer) {
    std::vector<float> fine(static_cast<size_t>(window.width * window.height));
    source.makePosts(finer, window.column, window.row, window.width, window.height, fine.data());
    for (int j = 0; j < window.height; ++j) {
        for (int i = 0; i < window.width; ++i) {
            const int64_t column = window.column + i, row = window.row + j;
            const double coarse = tile.at(source.info().scheme, column, row, tile.id.mip - finer);
            const double error = std::abs(
                coarse - static_cast<double>(fine[static_cast<size_t>(j * window.width + i)]));
            auto allowed = static_cast<double>(bounds.errorToFinest);
            const auto next = static_cast<double>(blockAt(source, finer, column, row).errorToNext);
            if (finer > 0) allowed = next;
            if (finer == tile.id.mip - 1) allowed = std::min(allowed, next);
            if (error <= allowed) continue;
            return fmt::format("tile ({}, {}) of mip {} is {} m off mip {}, more than {}",
                               tile.id.x, tile.id.y, tile.id.mip, error, finer, allowed);
        }
    }
    return {};
}

}  // namespace

std::string faultOfBlock(const TerabyteSource& source, TileReader& reader, std::mt19937& random) {
    const TilingScheme& scheme = source.info().scheme;
    TileSurface tile;
    tile.id.mip = pick(random, scheme.mipCount());
    tile.id.x = pick(random, scheme.tilesX(tile.id.mip));
    tile.id.y = pick(random, scheme.tilesY(tile.id.mip));
    const auto read = reader.read(tile.id, tile.posts.data(), kTilePosts);
    if (!read) return read.error().message;
    const int cellsX = scheme.cellsX(tile.id), cellsY = scheme.cellsY(tile.id);
    const int bx = pick(random, (cellsX + kBlockCells - 1) / kBlockCells);
    const int by = pick(random, (cellsY + kBlockCells - 1) / kBlockCells);
    const BlockBounds& bounds = source.block(tile.id, bx, by);
    std::string fault = heightFault(tile, bounds, bx * kBlockCells, by * kBlockCells,
                                    std::min((bx + 1) * kBlockCells, cellsX),
                                    std::min((by + 1) * kBlockCells, cellsY));
    for (const int finer : {0, tile.id.mip - 1}) {
        if (finer < 0 || finer >= tile.id.mip || !fault.empty()) continue;
        fault = errorFault(source, tile, bounds, windowIn(scheme, tile.id, bx, by, finer, random),
                           finer);
    }
    return fault;
}

double finestRms(const TerabyteSource& source, int tiles, std::mt19937& random) {
    const TilingScheme& scheme = source.info().scheme;
    double squares = 0, count = 0;
    std::vector<float> fine(size_t{kTilePosts} * kTilePosts);
    for (int k = 0; k < tiles; ++k) {
        TileSurface tile;
        tile.id = {1, pick(random, scheme.tilesX(1) - 1), pick(random, scheme.tilesY(1) - 1)};
        source.makePosts(1, int64_t{tile.id.x} * kTileCells, int64_t{tile.id.y} * kTileCells,
                         kTilePosts, kTilePosts, tile.posts.data());
        const int64_t column = int64_t{tile.id.x} * kTileCells * 2;
        const int64_t row = int64_t{tile.id.y} * kTileCells * 2;
        source.makePosts(0, column, row, kTilePosts, kTilePosts, fine.data());
        for (int j = 0; j < kTilePosts; ++j) {
            for (int i = 0; i < kTilePosts; ++i) {
                const double error =
                    tile.at(scheme, column + i, row + j, 1) -
                    static_cast<double>(fine[static_cast<size_t>(j * kTilePosts + i)]);
                squares += error * error;
                ++count;
            }
        }
    }
    return std::sqrt(squares / count);
}

}  // namespace terray::bench
