// SPDX-License-Identifier: Apache-2.0
// The hits of a batch, one array a quantity.
#pragma once

#include <span>

#include "kernel/layout/layout.h"
#include "shade/batch.h"

namespace terray {

/// Up to kBatch hits. Where there is none, but some elsewhere, one of the others stands in.
struct HitBatch {
    explicit HitBatch(std::span<const Hit> hits);

    Floats t, u, v;
    Ints tile, cell, mip, flags;
    Ints own;        ///< 1: a hit of its own, 0: a stand-in
    bool some, all;  ///< own hits: any, kBatch of them
    bool alike;      ///< all lie in one tile
    bool plain;      ///< none is from below or on a wall

    Hit hit(int k) const {
        return {t[k], static_cast<uint32_t>(tile[k]), static_cast<uint32_t>(cell[k]), u[k], v[k],
                0,    static_cast<uint8_t>(mip[k]),   static_cast<uint8_t>(flags[k])};
    }
};

}  // namespace terray
