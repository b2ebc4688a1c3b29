// SPDX-License-Identifier: Apache-2.0
// Ramps read in batches: two neighbouring entries are fetched at once, and weighed in SIMD loops.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/simd_clones.h"
#include "shade/ramp.h"

namespace terray {
namespace {

constexpr float kCodes = 65535.0f;
/// Scene value of the last code: display white is the brightest tint.
constexpr float kBrightest = rules::kWhite + 0.05f;

/// Two entries a lane, each r and g in one word, b and rock in the next.
struct EntryPairs {
    alignas(64) uint32_t words[kBatch * 4];
};

TERRAY_SIMD_CLONES
void blendEntries(const EntryPairs& pairs, const Floats& share, FloatsRgb& colour, Floats& rock) {
    constexpr float kUnit = kBrightest / kCodes;
    for (int k = 0; k < kBatch; ++k) {
        const auto word = [&](int n) { return static_cast<int32_t>(pairs.words[4 * k + n]); };
        const float f = share[k];
        const auto low = [&](int n) {
            const auto a = static_cast<float>(word(n) & 0xFFFF);
            return a + f * (static_cast<float>(word(n + 2) & 0xFFFF) - a);
        };
        const auto high = [&](int n) {
            const auto a = static_cast<float>((word(n) >> 16) & 0xFFFF);
            return a + f * (static_cast<float>((word(n + 2) >> 16) & 0xFFFF) - a);
        };
        colour.r[k] = low(0) * kUnit;
        colour.g[k] = high(0) * kUnit;
        colour.b[k] = low(1) * kUnit;
        rock[k] = high(1) * (1.0f / kCodes);
    }
}

/// Where heights lie in one of two parts of a table.
struct Choice {
    float shore, from[2], perMetre[2], last[2];
    int32_t first[2];
};

TERRAY_SIMD_CLONES
void locateEntries(const Choice& choice, const Floats& height, Ints& entry, Floats& share) {
    const Choice c = choice;
    for (int k = 0; k < kBatch; ++k) {
        const float h = height[k];
        const bool sea = h < c.shore;
        const float from = sea ? c.from[1] : c.from[0];
        const float perMetre = sea ? c.perMetre[1] : c.perMetre[0];
        const float last = sea ? c.last[1] : c.last[0];
        float x = (h - from) * perMetre;
        x = x < 0.0f ? 0.0f : x;
        x = x > last ? last : x;
        const auto whole = static_cast<int32_t>(x);
        const auto most = static_cast<int32_t>(last) - 1;
        const int32_t at = whole < most ? whole : most;
        entry[k] = (sea ? c.first[1] : c.first[0]) + at;
        share[k] = x - static_cast<float>(at);
    }
}

}  // namespace

TintTable::Part TintTable::append(const HeightRamp::Table& table, const rules::Rgb& bare) {
    const Part part{table.from, table.perMetre, static_cast<float>(table.tints.size() - 1),
                    static_cast<int32_t>(codes_.size() / 4)};
    const auto code = [](float v, float whole) {
        return static_cast<uint16_t>(std::lround(std::clamp(v / whole, 0.0f, 1.0f) * kCodes));
    };
    for (const Tint& tint : table.tints) {
        const rules::Rgb shown = glm::mix(bare, tint.colour, tint.cover);
        codes_.insert(codes_.end(), {code(shown.r, kBrightest), code(shown.g, kBrightest),
                                     code(shown.b, kBrightest), code(tint.rock, 1.0f)});
    }
    return part;
}

TintTable::TintTable(const HeightRamp& ramp, const rules::Rgb& bare)
    : shore_(ramp.sea_.tints.empty() ? std::numeric_limits<float>::lowest() : HeightRamp::kShore) {
    land_ = append(ramp.land_, bare);
    sea_ = ramp.sea_.tints.empty() ? land_ : append(ramp.sea_, bare);
}

void TintTable::at(const Floats& height, FloatsRgb& colour, Floats& rock) const {
    const Choice choice{shore_,
                        {land_.from, sea_.from},
                        {land_.perMetre, sea_.perMetre},
                        {land_.last, sea_.last},
                        {land_.first, sea_.first}};
    Ints entry;
    Floats share;
    EntryPairs pairs;
    locateEntries(choice, height, entry, share);
    for (int k = 0; k < kBatch; ++k)
        std::memcpy(&pairs.words[4 * k], &codes_[static_cast<size_t>(entry[k]) * 4], 16);
    blendEntries(pairs, share, colour, rock);
}

}  // namespace terray
