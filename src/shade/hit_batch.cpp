// SPDX-License-Identifier: Apache-2.0
// Takes hits apart.
#include "shade/hit_batch.h"

#include <algorithm>

#include "base/simd_clones.h"

namespace terray {
namespace {

/// Over the lanes: all flags together, flags that all have, and how tiles differ from the first's.
struct Survey {
    int32_t any, common, unlike;
};

TERRAY_SIMD_CLONES
Survey survey(const HitBatch& h) {
    int32_t any = 0, common = -1, unlike = 0;
    const int32_t first = h.tile[0];
    for (int k = 0; k < kBatch; ++k) {
        any |= h.flags[k];
        common &= h.flags[k];
        unlike |= h.tile[k] ^ first;
    }
    return {any, common, unlike};
}

/// Lane `from` stands in for the lanes without a hit.
TERRAY_SIMD_CLONES
void standIn(int from, HitBatch& h) {
    const Hit spare = h.hit(from);
    const auto tile = static_cast<int32_t>(spare.tile), cell = static_cast<int32_t>(spare.cell);
    const int32_t mip = spare.mip, flags = spare.flags;
    const float t = spare.t, u = spare.u, v = spare.v;
    for (int k = 0; k < kBatch; ++k) {
        const bool own = h.own[k] != 0;
        h.t[k] = own ? h.t[k] : t;
        h.u[k] = own ? h.u[k] : u;
        h.v[k] = own ? h.v[k] : v;
        h.tile[k] = own ? h.tile[k] : tile;
        h.cell[k] = own ? h.cell[k] : cell;
        h.mip[k] = own ? h.mip[k] : mip;
        h.flags[k] = own ? h.flags[k] : flags;
    }
}

TERRAY_SIMD_CLONES
void findOwn(HitBatch& h) {
    for (int k = 0; k < kBatch; ++k) h.own[k] = h.flags[k] & kHitValid;
}

}  // namespace

HitBatch::HitBatch(std::span<const Hit> hits) {
    const int count = static_cast<int>(hits.size());
    for (int k = 0; k < count; ++k) {
        const Hit& hit = hits[static_cast<size_t>(k)];
        t[k] = hit.t;
        tile[k] = static_cast<int32_t>(hit.tile);
        cell[k] = static_cast<int32_t>(hit.cell);
        u[k] = hit.u;
        v[k] = hit.v;
        mip[k] = hit.mip;
        flags[k] = hit.flags;
    }
    std::fill(flags.at + count, flags.at + kBatch, 0);
    findOwn(*this);
    Survey found = survey(*this);
    some = (found.any & kHitValid) != 0;
    all = (found.common & kHitValid) != 0;
    if (some && !all) {
        standIn(static_cast<int>(std::find(own.at, own.at + kBatch, 1) - own.at), *this);
        found = survey(*this);
    }
    alike = found.unlike == 0;
    plain = (found.any & ~kHitValid) == 0;
}

}  // namespace terray
