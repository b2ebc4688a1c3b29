// SPDX-License-Identifier: Apache-2.0
// Bounds files: BlockBounds of a whole mip as a TIFF of eight float bands, one pixel a block.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "store/shard_codec.h"

namespace terray {

/// Blocks a row and rows of blocks of a mip's bounds.
inline int boundsX(const TilingScheme& scheme, int mip) { return scheme.tilesX(mip) * kTileBlocks; }
inline int boundsY(const TilingScheme& scheme, int mip) { return scheme.tilesY(mip) * kTileBlocks; }

/// Bands: min, max, error to mip 0, error to the next mip, slope, cell range, coverage error,
/// flags. Lossless and deterministic. Error Failed.
Result<EncodedFile> encodeBounds(const TerrainInfo& info, int mip,
                                 std::span<const BlockBounds> bounds);

/// Of the bytes of a bounds file; `name` is for the sentence. Error Input if it is not what the
/// store says.
Result<std::vector<BlockBounds>> readBounds(const std::string& name,
                                            std::span<const std::byte> bytes,
                                            const TerrainInfo& info, int mip);

}  // namespace terray
