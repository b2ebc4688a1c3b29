// SPDX-License-Identifier: Apache-2.0
// What the column march's SIMD lanes leave to plain code.
#pragma once

#include "kernel/columns.h"

namespace terray::simd {

/// Lanes [p, p + count) of which[] enter the tile that is drawn at (x, y); where none is, slot
/// becomes kNoSlot.
void enterMarchTiles(const TerrainCut& cut, float anchorZ, const int32_t* x, const int32_t* y,
                     const int32_t* which, int count, MarchLanes& lanes, int p);

}  // namespace terray::simd
