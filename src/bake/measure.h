// SPDX-License-Identifier: Apache-2.0
// What is measured on the decoded posts: edges, bounds and errors of tiles, and how many holes.
#pragma once

#include <limits>
#include <vector>

#include "bake/workshop.h"
#include "store/bytes.h"

namespace terray {

/// Of posts of mip 0.
struct HeightTally {
    float minZ = std::numeric_limits<float>::infinity(), maxZ = -minZ;
    uint64_t holes = 0;
    void add(const HeightTally& other);
};

/// What one shard's blocks say. Errors of coarser mips are lower bounds of theirs: the largest over
/// all shards counts.
struct Measured {
    struct Tile {
        BlockBounds blocks[kTileBlocks * kTileBlocks] = {};
        Bytes edges;  ///< a record of the edge file
    };
    struct CoarseError {
        uint32_t mip = 0;
        uint64_t block = 0;  ///< place in the bounds of that mip
        float error = 0;
    };
    std::vector<Tile> tiles;  ///< of the blocks that are tiles, from left to right
    std::vector<CoarseError> errors;
    HeightTally tally;
};

Bytes encodeMeasured(const Measured& measured);
/// False if the bytes are something else.
bool decodeMeasured(std::span<const std::byte> bytes, Measured& measured);
std::string measuredPath(ShardId shard);
constexpr const char* kMeasuredFolder = "measured";

/// Errors to mip 0 are compared directly up to this mip: a tile of mip 0 covers whole cells of it.
/// Coarser ones add up bounds.
constexpr int kLastComparedMip = kTileCellsLog2;

/// Measures all shards of all mips, each into a finished file of its own.
Result<void> measureAll(Workshop& shop);

}  // namespace terray
