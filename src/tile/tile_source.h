// SPDX-License-Identifier: Apache-2.0
// TileSource: whoever delivers finished tiles of all mips with their bounds (the store).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "base/result.h"
#include "tile/terrain_info.h"

namespace terray {

/// Reads one tile at a time. One reader per thread (confined).
class TileReader {
public:
    virtual ~TileReader() = default;
    /// Fills (cellsX + 1) x (cellsY + 1) posts, `stride` apart from row to row: the tile's own and
    /// its 513th row and column. Heights in metres; holes are NaN.
    virtual Result<void> read(TileId id, float* posts, ptrdiff_t stride) = 0;
    /// The same as codes (info().format == Int16 only); holes are kHolePost.
    virtual Result<void> readCodes(TileId id, uint16_t* codes, ptrdiff_t stride) = 0;
    /// Bytes read of files, as they lie there; 0 where there are none.
    virtual uint64_t bytesRead() const { return 0; }
};

/// const-shared: any thread may ask for a reader.
class TileSource {
public:
    virtual ~TileSource() = default;
    virtual const TerrainInfo& info() const = 0;  ///< minZ, maxZ are exact
    virtual uint64_t holes() const = 0;           ///< posts of mip 0 without a height
    /// Of all blocks of a mip, row by row: 8 * tilesX(mip) a row, 8 * tilesY(mip) rows.
    virtual std::span<const BlockBounds> bounds(int mip) const = 0;
    /// Frees the bounds of all mips: whoever has copied them asks no more. No reader is at work.
    virtual void dropBounds() {}
    /// Block (x, y) of a tile, 0 .. 7 each.
    const BlockBounds& block(TileId id, int x, int y) const {
        const auto width = static_cast<size_t>(info().scheme.tilesX(id.mip)) * kTileBlocks;
        const size_t row = static_cast<size_t>(id.y) * kTileBlocks + static_cast<size_t>(y);
        return bounds(
            id.mip)[row * width + static_cast<size_t>(id.x) * kTileBlocks + static_cast<size_t>(x)];
    }
    virtual Result<std::unique_ptr<TileReader>> makeReader() const = 0;
    /// Reading waits for a network rather than for work: many readers help, and patience.
    virtual bool isRemote() const { return false; }
    /// Nobody waits any more: reads that are under way should end, if they can, and later ones
    /// fail.
    virtual void stopReading() const {}
};

}  // namespace terray
