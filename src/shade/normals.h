// SPDX-License-Identifier: Apache-2.0
// Filtered gradients of the terrain: from the mip that fits a footprint, smooth across cells, tiles
// and mips, whatever mips the frame draws: those that it wants for this are resident too, or late.
#pragma once

#include <glm/vec2.hpp>

#include "kernel/layout/layout.h"
#include "shade/batch.h"
#include "tile/tile_id.h"

namespace terray {

/// const-shared.
class FilteredGradient {
public:
    FilteredGradient(const TerrainCut& cut, const TilingScheme& scheme);

    /// (dz/di, dz/dj) per mip-0 cell at a lattice place; `footprint` is the width to average over,
    /// in mip-0 cells. False where no mip has a surface there (a hole): `gradient` is untouched.
    bool at(double i, double j, float footprint, glm::vec2& gradient) const;

    /// The same at kBatch places, most of them in SIMD.
    void at(const Places& places, const Floats& footprint, Floats2& gradient) const;

    /// Gradient of one mip by the cubic B-spline through central differences.
    bool ofMip(int mip, double i, double j, glm::vec2& gradient) const;

private:
    struct Patches;
    struct LastTile;
    void enter(int mip, int32_t x, int32_t y, LastTile& tile) const;
    void fetch(const Ints& mip, int step, Patches& patches) const;
    bool gather(int mip, int64_t column, int64_t row, float (&z)[4][4]) const;
    bool atLate(int mip, double i, double j, glm::vec2& gradient) const;
    float postAt(int mip, int64_t i, int64_t j) const;

    const TerrainCut& cut_;
    int maxMip_ = 0;
    int64_t columns_[kMaxMips] = {}, rows_[kMaxMips] = {};
    double cellsAcross_[kMaxMips] = {};  ///< cells of a mip per mip-0 cell: 2^-mip
};

}  // namespace terray
