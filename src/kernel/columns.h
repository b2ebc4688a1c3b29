// SPDX-License-Identifier: Apache-2.0
// Column marching: rays of one image row that begin where those of the row below have hit
// (docs/traversal.md). A row of neighbouring columns at once, one a
// SIMD lane.
#pragma once

#include <array>
#include <cstdint>

#include "kernel/layout/layout.h"

namespace terray {

constexpr int kMarchColumns = 256;

/// What makes a ray, each a sum of a part of its column and a part of its row. w is the parameter
/// that all rays of a picture share (RayFrame::PencilRay).
enum RayTerm {
    kTermX,  ///< place at w = 0, lattice
    kTermY,
    kTermZ,   ///< true metres
    kTermDx,  ///< change of place per w
    kTermDy,
    kTermDz,
    kTermLength2,   ///< square of metres in picture space per w
    kTermForward0,  ///< metres ahead at w = 0, horizontally: see MarchTile::forward
    kTermForward,   ///< metres ahead per w
    kTermCount
};
using RayTerms = std::array<double, kTermCount>;

/// The columns of an image tile, relative to an anchor on its middle ray at w = w0. Heights are
/// relative to anchorZ.
struct alignas(64) MarchTile {
    float columns[kTermCount][kMarchColumns];
    double anchorX = 0, anchorY = 0;  ///< whole numbers
    double anchorZ = 0, w0 = 0;       ///< anchorZ is a float
    double bend = 0;                  ///< of a level metre: c = (1 - k) / 2R
    double exaggeration = 1;          ///< picture heights per true height
    bool eyeOutside = false;          ///< some ray may begin outside the terrain's rectangle
    float reach[kTermCount];          ///< largest |column part|
};

/// The part of a row, relative to the same anchor.
struct MarchRow {
    float terms[kTermCount];
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
    int32_t steps[kMarchColumns];   ///< cells; in: of the row below, a hint
    int32_t slot[kMarchColumns], cell[kMarchColumns];
    float t[kMarchColumns], u[kMarchColumns], v[kMarchColumns];
    float clear[kMarchColumns];  ///< distance up to which an undecided ray is above the surface
    // the tile in which the lane last stood; slot == kNoSlot: none
    int32_t tileX[kMarchColumns], tileY[kMarchColumns], mip[kMarchColumns];
    int32_t postsOffset[kMarchColumns];
    /// 16-bit posts: z - anchorZ = postsZ + postsStep * (code - postsCode), all of them small.
    int32_t postsCode[kMarchColumns];
    float postsZ[kMarchColumns], postsStep[kMarchColumns];
    /// in: of a row below: metres ahead up to which its rays are above the surface; negative: not
    /// known. From column -kMarchReach to beyond the last by as many; aligned.
    const float* below = nullptr;
};

/// Lanes that stand nowhere yet and know nothing.
void resetLanes(MarchLanes& lanes);
/// Tells the lanes of another tile.anchorZ.
void anchorLanes(const TerrainCut& cut, double anchorZ, MarchLanes& lanes);

/// What came of a row.
struct MarchCounts {
    int hits = 0, left = 0, steps = 0;
};

/// Marches the rays of a row, columns [begin, end), a few cells each from where the rays of the row
/// below between which they stand are both still above the surface. Not for constant surfaces. A
/// hit is the ray's first for certain if below[] and limit[] are true. hits[k] is column k's,
/// without kHitValid where there is none (yet); past[] tells of this row then.
MarchCounts marchRow(const TerrainCut& cut, const MarchTile& tile, const MarchRow& row, int begin,
                     int end, MarchLanes& lanes, Hit* hits);

}  // namespace terray
