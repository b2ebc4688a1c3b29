// SPDX-License-Identifier: Apache-2.0
// Which mips to blend for a footprint: used alike for normals, sky light and photos.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace terray::rules {

/// log2 of a positive number, good to 0.01: from the float's own exponent and mantissa.
inline float roughLog2(float v) {
    const auto bits = std::bit_cast<uint32_t>(v);
    const float exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
    const float m = std::bit_cast<float>((bits & 0x007FFFFFu) | 0x3F800000u);
    return exponent + (-0.344845f * m + 2.024658f) * m - 1.674873f;
}

struct MipBlend {
    int mip = 0;
    float coarser = 0;  ///< share of mip + 1
};

/// For a footprint in samples of mip 0. Blends over the middle half of the way only, so that half
/// of all places need one mip and not two.
inline MipBlend mipBlend(float footprint, int last) {
    const float wanted =
        std::clamp(roughLog2(std::max(footprint, 1e-6f)), 0.0f, static_cast<float>(last));
    const int mip = static_cast<int>(wanted);
    const float share = (wanted - static_cast<float>(mip)) * 2.0f - 0.5f;
    return {mip, mip < last ? std::clamp(share, 0.0f, 1.0f) : 0.0f};
}

}  // namespace terray::rules
