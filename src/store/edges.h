// SPDX-License-Identifier: Apache-2.0
// Edge files: the decoded 513th row and column of every tile of a mip, without loss.
#pragma once

#include <cstdint>
#include <span>

#include "store/bytes.h"
#include "store/format.h"
#include "store/hashes.h"

namespace terray {

/// The first 32 bytes of the edge file of a mip.
Bytes encodeEdgeHeader(const TerrainInfo& info, int mip);

/// Where the record of a tile lies: its 513th row from left to right (513 posts), then its 513th
/// column from top to bottom (512 posts); floats or codes, holes where there is no such post.
BlockRange edgeRange(const TerrainInfo& info, TileId id);

uint64_t edgeFileBytes(const TerrainInfo& info, int mip);

/// Records of all tiles, for the hashes.
std::vector<BlockRange> edgeRanges(const TerrainInfo& info, int mip);

}  // namespace terray
