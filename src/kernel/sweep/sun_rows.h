// SPDX-License-Identifier: Apache-2.0
// The inner loops of the sun sweep, one row of strips at a time.
#pragma once

#include <cstdint>

namespace terray {

/// Decoded posts: z = step * code + base, NaN for the code of holes; or z = post + base.
void decodePosts(const uint16_t* posts, int count, float step, float base, float* heights);
void decodePosts(const float* posts, int count, float step, float base, float* heights);

/// One step of the sweep: from row r + 1 to row r, for `count` strips that lie side by side.
/// Arrays start at the first strip, or at the first column that it touches.
struct SunRow {
    const float* here;   ///< posts of row r; NaN in holes
    const float* edges;  ///< per column: the greatest height on the edge between rows r and r + 1,
                         ///< less what a ray has risen there at least
    const float* twist;  ///< per cell: how far a ray's profile may rise above its ends
    const float* holes;  ///< per column: -infinity where a post of row r or r + 1 is missing;
                         ///< null: nowhere
    float* top;          ///< greatest height of the strip's piece of row r + 1, then of row r
    float* free;         ///< bounds of row r + 1, then of row r
    float* caught;
    uint32_t* entries;  ///< codes of row r
    int count;
    int edge[3];                  ///< columns in the strip's way between the rows
    int cell[4];                  ///< cells there
    int right;                    ///< column left of the right end of the strip's piece of row r
    float leftPlace, rightPlace;  ///< ends of that piece in their columns, 0..1
    float drop, dropPerStrip;     ///< how far a ray sinks from row r + 1 to row r
    float slack;                  ///< of the drop
    float codeZ, codesPerMetre;
};

void sweepRow(const SunRow& row);

/// Between row r (`here`) and r + 1 (`ahead`): edges and twist of a SunRow. `rise`: the least that
/// a ray rises from row to row; `share` of a cell's twist and `arc` of the ray are what a profile
/// may stand above the chord of its ends. True if there are holes, which are left out.
bool prepareBand(const float* here, const float* ahead, int count, float rise, float share,
                 float arc, float* edges, float* twist);
/// Per column -infinity where either post is missing, else 0.
void markHoles(const float* a, const float* b, int count, float* holes);

/// The entry of two bounds: code of `free` rounded up in the high half (65535: unknown), of
/// `caught` rounded down in the low half (0: unknown).
constexpr uint32_t kUnknownFree = 0xFFFFu;

}  // namespace terray
