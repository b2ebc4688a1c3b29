// SPDX-License-Identifier: Apache-2.0
// Pixels are shaded in batches: one array a quantity, and one plain loop a step, which the compiler
// turns into SIMD (base/simd_clones.h). What cannot be a SIMD load is fetched by a scalar loop
// between.
#pragma once

#include <cstdint>
#include <cstring>

namespace terray {

constexpr int kBatch = 64;

template <class T>
struct alignas(64) Lanes {
    T at[kBatch];
    T& operator[](int k) { return at[k]; }
    const T& operator[](int k) const { return at[k]; }
};
using Floats = Lanes<float>;
using Doubles = Lanes<double>;
using Ints = Lanes<int32_t>;

struct Floats2 {
    Floats x, y;
};
struct Floats3 {
    Floats x, y, z;
};
/// Places on the mip-0 lattice: (x + dx, y + dy), the whole part anywhere before it.
struct Places {
    Ints x, y;
    Floats dx, dy;
    double i(int k) const { return static_cast<double>(x[k]) + static_cast<double>(dx[k]); }
    double j(int k) const { return static_cast<double>(y[k]) + static_cast<double>(dy[k]); }
};
/// Two codes of a row and two of the next, from the low end: one store instead of two or four.
inline uint64_t fourCodes(const uint16_t* top, const uint16_t* bottom) {
    uint32_t upper, lower;
    std::memcpy(&upper, top, sizeof upper);
    std::memcpy(&lower, bottom, sizeof lower);
    return uint64_t{lower} << 32 | upper;
}
/// Colours, linear light.
struct FloatsRgb {
    Floats r, g, b;
};

}  // namespace terray
