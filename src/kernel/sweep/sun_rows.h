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
    const float* ahead;  ///< posts of row r + 1, likewise
    const float* edges;  ///< per column: what a ray must clear on the edge between rows r and r +
                         ///< 1, less what it has risen there at least; -infinity between cells that
                         ///< face the sun
    const float* twist;  ///< per cell: how far a ray's profile may rise above its ends; -infinity
                         ///< where the cell faces the sun
    const float* holes;  ///< per column: -infinity where a post of row r or r + 1 is missing;
                         ///< null: nowhere
    float* free;         ///< bounds of row r + 1, then of row r
    float* caught;
    uint32_t* entries;  ///< of row r, which take `caught`; null if it keeps none
    uint32_t* kept;     ///< of the kept row before, which take `free`; null if there is none
    int keptCount;      ///< strips that reach from here to that row
    int count;
    int edge[3];                  ///< columns in the strip's way between the rows
    int cell[4];                  ///< cells there
    int right;                    ///< column left of the right end of the strip's piece of row r
    int leftAhead, rightAhead;    ///< columns left of the ends of its piece of row r + 1
    float leftPlace, rightPlace;  ///< ends of those pieces in their columns, 0..1
    float leftPlaceAhead, rightPlaceAhead;
    float drop, dropPerStrip;  ///< how far a ray sinks from row r + 1 to row r
    float slack;               ///< of the drop
    float codeZ, codesPerMetre;
};

void sweepRow(const SunRow& row);
/// The codes of a row whose bounds stand.
void codeRow(const SunRow& row);

/// Rays over a band of two rows of posts.
struct SunBand {
    float shear;
    float rise;    ///< the least that a ray rises from row to row
    float facing;  ///< ground that rises by less along it certainly faces the sun
    float arc;     ///< how far a ray hangs below the chord of its ends
};

/// Between row r (`here`) and r + 1 (`ahead`): edges and twist of a SunRow. True if there are
/// holes, which are left out.
bool prepareBand(const float* here, const float* ahead, int count, const SunBand& band,
                 float* edges, float* twist);
/// Per column -infinity where either post is missing, else 0.
void markHoles(const float* a, const float* b, int count, float* holes);

}  // namespace terray
