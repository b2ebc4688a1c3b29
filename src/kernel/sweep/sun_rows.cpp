// SPDX-License-Identifier: Apache-2.0
// Written as plain loops that the compiler turns into lanes. Comparisons stand so that a NaN (hole)
// loses.
#include "kernel/sweep/sun_rows.h"

#include <cmath>
#include <limits>

#include "base/simd_clones.h"
#include "kernel/sweep/sun.h"

namespace terray {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// More than the error of a place on the scale of codes: three roundings of up to 65536 * 2^-24.
constexpr float kCodeSlack = 0.05f;

inline float greater(float a, float b) { return a > b ? a : b; }
inline float lesser(float a, float b) { return a < b ? a : b; }

}  // namespace

TERRAY_SIMD_CLONES
void decodePosts(const uint16_t* __restrict posts, int count, float step, float base,
                 float* __restrict heights) {
    constexpr float kHole = std::numeric_limits<float>::quiet_NaN();
    for (int k = 0; k < count; ++k) {
        const float z = step * static_cast<float>(posts[k]) + base;
        heights[k] = posts[k] == 0xFFFF ? kHole : z;
    }
}

TERRAY_SIMD_CLONES
void decodePosts(const float* __restrict posts, int count, float /*step*/, float base,
                 float* __restrict heights) {
    for (int k = 0; k < count; ++k) heights[k] = posts[k] + base;
}

namespace {

/// Bounds of row r, from those of row r + 1. Over cells that face the sun a ray only gains height:
/// there it has nothing to clear.
TERRAY_SIMD_CLONES
void boundRow(const SunRow& row) {
    const float* __restrict here = row.here;
    const float* __restrict here1 = here + row.right;
    const float* __restrict ahead = row.ahead + row.leftAhead;
    const float* __restrict ahead1 = row.ahead + row.rightAhead;
    const float* __restrict edges = row.edges;
    const float* __restrict twist = row.twist;
    const float* __restrict twist1 = twist + row.right;
    const float* __restrict twistAhead = twist + row.leftAhead;
    const float* __restrict twistAhead1 = twist + row.rightAhead;
    float* __restrict free = row.free;
    float* __restrict caught = row.caught;
    const int e0 = row.edge[0], e1 = row.edge[1], e2 = row.edge[2];
    const float atLeft = row.leftPlace, atRight = row.rightPlace;
    const float atLeftAhead = row.leftPlaceAhead, atRightAhead = row.rightPlaceAhead;
    const float drop = row.drop, perStrip = row.dropPerStrip, slack = row.slack;
    const int count = row.count;
#if !defined(__clang__)
#pragma GCC ivdep
#endif
    for (int k = 0; k < count; ++k) {
        const float sinks = drop + perStrip * static_cast<float>(k);
        const float l0 = here[k], l1 = here[k + 1], r0 = here1[k], r1 = here1[k + 1];
        const float left = l0 + (l1 - l0) * atLeft, right = r0 + (r1 - r0) * atRight;
        const float leftAhead = ahead[k] + (ahead[k + 1] - ahead[k]) * atLeftAhead;
        const float rightAhead = ahead1[k] + (ahead1[k + 1] - ahead1[k]) * atRightAhead;
        const float low = lesser(lesser(left, right), lesser(l1, r0));
        const float near = greater(left + twist[k], greater(right + twist1[k], -kInfinity));
        const float far =
            greater(leftAhead + twistAhead[k], greater(rightAhead + twistAhead1[k], -kInfinity));
        const float band = greater(greater(edges[k + e0], edges[k + e1]), edges[k + e2]);
        const float beyond = greater(far, free[k]) - (sinks - slack);
        free[k] = greater(greater(near, band), beyond);
        caught[k] = greater(low, caught[k] - (sinks + slack));
    }
    if (row.holes == nullptr) return;
    for (int k = 0; k < count; ++k) {
        float missing = 0;
        for (int c = row.cell[0]; c <= row.cell[3] + 1; ++c) missing += row.holes[k + c];
        if (missing != 0.0f) caught[k] = -kInfinity;
    }
}

TERRAY_SIMD_CLONES
void codeCaught(const float* __restrict caught, int count, float codeZ, float scale,
                uint32_t* __restrict entries) {
    for (int k = 0; k < count; ++k) {
        const float down =
            lesser(greater((caught[k] - codeZ) * scale - kCodeSlack, 0.0f), 65535.0f);
        entries[k] = kUnknownFree << 16 | static_cast<uint32_t>(static_cast<int32_t>(down));
    }
}

TERRAY_SIMD_CLONES
void codeFree(const float* __restrict free, int count, float codeZ, float scale,
              uint32_t* __restrict entries) {
    for (int k = 0; k < count; ++k) {
        const float up =
            lesser(greater((free[k] - codeZ) * scale + (1.0f + kCodeSlack), 0.0f), 65535.0f);
        entries[k] = static_cast<uint32_t>(static_cast<int32_t>(up)) << 16 | (entries[k] & 0xFFFFu);
    }
}

}  // namespace

void codeRow(const SunRow& row) {
    if (row.entries) codeCaught(row.caught, row.count, row.codeZ, row.codesPerMetre, row.entries);
    if (row.kept) codeFree(row.free, row.keptCount, row.codeZ, row.codesPerMetre, row.kept);
}

void sweepRow(const SunRow& row) {
    boundRow(row);
    codeRow(row);
}

TERRAY_SIMD_CLONES
bool prepareBand(const float* __restrict here, const float* __restrict ahead, int count,
                 const SunBand& band, float* __restrict edges, float* __restrict twist) {
    const float rise = band.rise, facing = band.facing, shear = band.shear;
    const float share = 0.2501f * shear, arc = 0.2501f * band.arc;
    int missing = 0;
    for (int c = 0; c < count; ++c) {
        const float x = here[c], y = ahead[c];
        const float bent = (ahead[c + 1] - y) - (here[c + 1] - x);
        const float bulge = greater(share * (bent < 0.0f ? -bent : bent) + arc, arc);
        // The ground's slope along the rays is linear: steepest in one of two corners.
        const float along = shear * (here[c + 1] - x) + (y - x);
        const float steepest = along + (1.0f + shear) * (bent > 0.0f ? bent : 0.0f);
        const bool faces = (steepest < facing) & (bent == bent);
        twist[c] = faces ? -kInfinity : bulge;
        missing |= (x != x) | (y != y);
    }
    edges[0] = kInfinity;  // beside all strips
    for (int c = 1; c < count; ++c) {
        const float most = greater(here[c], greater(ahead[c] - rise, -kInfinity));
        edges[c] = most + greater(twist[c - 1], twist[c]);
    }
    return missing != 0;
}

void markHoles(const float* a, const float* b, int count, float* holes) {
    for (int c = 0; c < count; ++c)
        holes[c] = std::isnan(a[c]) || std::isnan(b[c]) ? -kInfinity : 0.0f;
}

}  // namespace terray
