// SPDX-License-Identifier: Apache-2.0
// Takes hits apart.
#include "shade/hit_batch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

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

/// Lies over other types, as memory does.
using HitWord [[gnu::may_alias]] = uint64_t;

/// Hits as three words each: a store of a word at a time would take longer than all arithmetic on
/// it.
TERRAY_SIMD_CLONES
void split(const HitWord* __restrict words, HitBatch& h) {
    static_assert(std::endian::native == std::endian::little && sizeof(Hit) == 24);
    static_assert(offsetof(Hit, tile) == 4 && offsetof(Hit, cell) == 8 && offsetof(Hit, u) == 12 &&
                  offsetof(Hit, v) == 16 && offsetof(Hit, mip) == 22 && offsetof(Hit, flags) == 23);
    const auto low = [](uint64_t word) { return static_cast<int32_t>(word); };
    const auto high = [](uint64_t word) { return static_cast<int32_t>(word >> 32); };
    for (int k = 0; k < kBatch; ++k) {
        const uint64_t a = words[3 * k], b = words[3 * k + 1], c = words[3 * k + 2];
        h.t[k] = std::bit_cast<float>(low(a));
        h.tile[k] = high(a);
        h.cell[k] = low(b);
        h.u[k] = std::bit_cast<float>(high(b));
        h.v[k] = std::bit_cast<float>(low(c));
        const int32_t rest = high(c);
        h.mip[k] = (rest >> 16) & 0xFF;
        h.flags[k] = (rest >> 24) & 0xFF;
        h.own[k] = (rest >> 24) & kHitValid;
    }
}

}  // namespace

HitBatch::HitBatch(std::span<const Hit> hits) {
    if (hits.size() == kBatch) {
        split(reinterpret_cast<const HitWord*>(hits.data()), *this);
    } else {
        std::array<Hit, kBatch> padded{};
        std::copy(hits.begin(), hits.end(), padded.begin());
        split(reinterpret_cast<const HitWord*>(padded.data()), *this);
    }
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
