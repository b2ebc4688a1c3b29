// SPDX-License-Identifier: Apache-2.0
// Written as plain loops that the compiler turns into lanes. Comparisons stand so that a NaN (hole)
// loses.
#include "kernel/sweep/sun_rows.h"

#include <cmath>
#include <limits>

#include "base/simd_clones.h"

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

TERRAY_SIMD_CLONES
void sweepRow(const SunRow& row) {
    const float* __restrict here = row.here;
    const float* __restrict here1 = here + row.right;
    const float* __restrict edges = row.edges;
    const float* __restrict twist = row.twist;
    float* __restrict tops = row.top;
    float* __restrict free = row.free;
    float* __restrict caught = row.caught;
    uint32_t* __restrict entries = row.entries;
    const int e0 = row.edge[0], e1 = row.edge[1], e2 = row.edge[2];
    const int c0 = row.cell[0], c1 = row.cell[1], c2 = row.cell[2], c3 = row.cell[3];
    const float leftPlace = row.leftPlace, rightPlace = row.rightPlace;
    const float drop = row.drop, perStrip = row.dropPerStrip, slack = row.slack;
    const float codeZ = row.codeZ, scale = row.codesPerMetre;
    const int count = row.count;
#if !defined(__clang__)
#pragma GCC ivdep
#endif
    for (int k = 0; k < count; ++k) {
        const float sinks = drop + perStrip * static_cast<float>(k);
        const float l0 = here[k], l1 = here[k + 1], r0 = here1[k], r1 = here1[k + 1];
        const float left = l0 + (l1 - l0) * leftPlace, right = r0 + (r1 - r0) * rightPlace;
        const float high = greater(greater(l1, r0), greater(left, greater(right, -kInfinity)));
        const float low = lesser(lesser(left, right), lesser(l1, r0));
        const float bulge =
            greater(greater(twist[k + c0], twist[k + c1]), greater(twist[k + c2], twist[k + c3]));
        const float band = greater(greater(edges[k + e0], edges[k + e1]), edges[k + e2]);
        const float surface = greater(greater(high, band), tops[k] - (sinks - slack)) + bulge;
        const float top = greater(surface, free[k] - (sinks - slack));
        const float floor = greater(low, caught[k] - (sinks + slack));
        tops[k] = high;
        free[k] = top;
        caught[k] = floor;
        const float up =
            lesser(greater((top - codeZ) * scale + (1.0f + kCodeSlack), 0.0f), 65535.0f);
        const float down = lesser(greater((floor - codeZ) * scale - kCodeSlack, 0.0f), 65535.0f);
        entries[k] = static_cast<uint32_t>(static_cast<int32_t>(up)) << 16 |
                     static_cast<uint32_t>(static_cast<int32_t>(down));
    }
    if (row.holes == nullptr) return;
    for (int k = 0; k < count; ++k) {
        float missing = 0;
        for (int c = row.cell[0]; c <= row.cell[3] + 1; ++c) missing += row.holes[k + c];
        if (missing == 0.0f) continue;
        caught[k] = -kInfinity;
        entries[k] &= 0xFFFF0000u;
    }
}

TERRAY_SIMD_CLONES
bool prepareBand(const float* __restrict here, const float* __restrict ahead, int count, float rise,
                 float share, float arc, float* __restrict edges, float* __restrict twist) {
    int missing = 0;
    for (int c = 0; c < count; ++c) {
        const float x = here[c], y = ahead[c];
        edges[c] = greater(x, greater(y - rise, -kInfinity));
        const float bent = (ahead[c + 1] - y) - (here[c + 1] - x);
        twist[c] = greater(share * (bent < 0.0f ? -bent : bent) + arc, arc);
        missing |= (x != x) | (y != y);
    }
    return missing != 0;
}

void markHoles(const float* a, const float* b, int count, float* holes) {
    for (int c = 0; c < count; ++c)
        holes[c] = std::isnan(a[c]) || std::isnan(b[c]) ? -kInfinity : 0.0f;
}

}  // namespace terray
