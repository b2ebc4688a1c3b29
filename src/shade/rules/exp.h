// SPDX-License-Identifier: Apache-2.0
// The exponential of haze and sky as plain arithmetic, so that loops over it become SIMD loops.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace terray::rules {

/// e^x for x <= 0, relative error below (4 + 1.5 |x|) 1e-7: 2^whole * 2^part, the latter by its
/// Taylor series.
inline float expOf(float x) {
    const float y = std::max(x * 1.44269504f, -126.0f);
    const auto whole = static_cast<int32_t>(y - 0.5f);  // the nearest: y is not positive
    const float f = y - static_cast<float>(whole);
    float p = 1.54035304e-4f;
    p = p * f + 1.33335581e-3f;
    p = p * f + 9.61812911e-3f;
    p = p * f + 5.55041087e-2f;
    p = p * f + 2.40226507e-1f;
    p = p * f + 6.93147181e-1f;
    p = p * f + 1.0f;
    return p * std::bit_cast<float>((whole + 127) << 23);
}

}  // namespace terray::rules
