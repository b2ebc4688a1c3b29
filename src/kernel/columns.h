// SPDX-License-Identifier: Apache-2.0
// Column marching: rays of one image row that begin where those of the row below have hit
// (docs/traversal.md). A row of neighbouring columns at once, one a
// SIMD lane.
#pragma once

#include <cstdint>

#include "kernel/layout/layout.h"
#include "kernel/ray_terms.h"

namespace terray {

constexpr int kMarchColumns = 256;
constexpr int kMarchRows = 16;          ///< of a chunk: rows that share anchors
constexpr int kMarchGroupColumns = 16;  ///< columns that share an anchor

/// Bounds of the float rays' errors: height0 + height1 |w| metres, and shift0 + shift1 |w| cells of
/// mip 0.
struct MarchErrors {
    float height0, height1, shift0, shift1;
    float rounding;  ///< of the posts
};

/// Neighbouring columns in a chunk of rows, relative to an anchor near where their rays are
/// expected to hit, at w = w0. Heights are relative to anchorZ. A ray is its column's part and its
/// row's.
struct alignas(64) MarchGroup {
    float columns[kTermCount][kMarchGroupColumns];
    float rows[kMarchRows][kTermCount];
    int32_t anchorX = 0, anchorY = 0;
    float anchorZ = 0, w0 = 0;
    float bend = 0;           ///< of a level metre: c = (1 - k) / 2R
    float exaggeration = 1;   ///< picture heights per true height
    float span = 0;           ///< no ray stays longer in a cell of mip 0, w; 0: not known
    bool eyeOutside = false;  ///< some ray may begin outside the terrain's rectangle
    MarchErrors errors{};
};
constexpr int kMarchGroups = kMarchColumns / kMarchGroupColumns;

/// A row of a chunk.
struct MarchRow {
    int index = 0;  ///< in the chunk
    /// Columns aside, to the right, at which a ray looks for the rays of the row below between
    /// which it stands.
    int first = 0, last = 0;
};

constexpr int kMarchReach = 3;  ///< most columns that a ray may look aside
constexpr int kMarchPad = 16;
static_assert(kMarchReach <= kMarchPad);

enum MarchResult : int32_t {
    kMarchLeft = 0,  ///< not decided: trace the ray from clear[k] on
    kMarchHit = 1,
    kMarchMiss = 2,
    kMarchCell = 3,  ///< hits in this cell, but float arithmetic does not tell well enough where
};

enum MarchCalm : uint8_t { kNotCalm = 0, kCalm = 1, kCalmAnchored = 2 };

/// The tile in which all lanes of a calm packet stand.
struct MarchPlateau {
    float inverse, size;  ///< mip-0 cells to its own, and back
    int32_t x, y;         ///< its first cell from the anchor, own cells
    int32_t endX, endY;   ///< its cells inside the terrain
    int32_t slot, mip;
    int32_t postsOffset, postsCode;  ///< as in MarchLanes
    float postsZ, postsStep;
};

/// Lanes of one march, in and out.
struct alignas(64) MarchLanes {
    // in
    float limit[kMarchColumns];   ///< metres ahead from which a ray begins at the latest
    float sure[kMarchColumns];    ///< metres ahead up to which a ray is above the surface anyway
    int32_t past[kMarchColumns];  ///< not 0: the ray below has left the terrain
    // out
    float forward[kMarchColumns];   ///< as below[], of this row: the hit, or the way out
    int32_t result[kMarchColumns];  ///< MarchResult
    int32_t begun[kMarchColumns];   ///< not 0: the row below has told where to begin
    int32_t left[kMarchColumns];    ///< the columns that are neither hits nor misses (yet)
    int32_t steps[kMarchColumns];   ///< cells
    int32_t slot[kMarchColumns], cell[kMarchColumns];
    float t[kMarchColumns], u[kMarchColumns], v[kMarchColumns];
    float clear[kMarchColumns];  ///< distance up to which an undecided ray is above the surface
    // the tile in which the lane last stood; slot == kNoSlot: none
    int32_t tileX[kMarchColumns], tileY[kMarchColumns], mip[kMarchColumns];
    int32_t postsOffset[kMarchColumns];
    /// 16-bit posts: z - the group's anchorZ = postsZ + postsStep * (code - postsCode), all of them
    /// small.
    int32_t postsCode[kMarchColumns];
    float postsZ[kMarchColumns], postsStep[kMarchColumns];
    /// By packet: whether all its lanes needed one cell in the row below, all of one tile, and that
    /// tile.
    uint8_t calm[kMarchColumns];  ///< MarchCalm
    MarchPlateau plateaus[kMarchColumns];
    /// By group of columns: a ray of the row below was traced by others.
    bool disturbed[kMarchGroups];
    /// in: of a row below: metres ahead up to which its rays are above the surface; negative: not
    /// known. From column -kMarchReach to beyond the last by as many; aligned.
    const float* below = nullptr;
};

/// Lanes that stand nowhere yet and know nothing.
void resetLanes(MarchLanes& lanes);
/// Tells the lanes of other anchors.
void anchorLanes(const TerrainCut& cut, const MarchGroup* groups, MarchLanes& lanes);

/// What came of a row.
struct MarchCounts {
    int hits = 0, left = 0, steps = 0;
};

/// Marches the rays of a row, columns [begin, end), a few cells each from where the rays of the row
/// below between which they stand are both still above the surface. Not for constant surfaces. A
/// hit is the ray's first for certain if below[] and limit[] are true. hits[k] is column k's,
/// without kHitValid where there is none (yet); past[] tells of this row then.
MarchCounts marchRow(const TerrainCut& cut, const MarchGroup* groups, const MarchRow& row,
                     int begin, int end, MarchLanes& lanes, Hit* hits);

}  // namespace terray
