// SPDX-License-Identifier: Apache-2.0
// Decoding and encoding of 16-bit posts, in loops that vectorise.
#include "tile/codes.h"

#include <bit>
#include <cmath>

#include "base/simd_clones.h"
#include "tile/terrain_info.h"

namespace terray {

TERRAY_SIMD_CLONES
void decodeCodes(const uint16_t* codes, int count, float z0, float zStep, float* out) {
    for (int k = 0; k < count; ++k) {
        const uint32_t code = codes[k];
        const float height = std::fma(zStep, static_cast<float>(static_cast<int32_t>(code)), z0);
        const uint32_t hole = code == kHolePost ? 0xFFFFFFFFu : 0u;  // all ones: a NaN
        out[k] = std::bit_cast<float>(std::bit_cast<uint32_t>(height) | hole);
    }
}

TERRAY_SIMD_CLONES
void encodeHeights(const float* __restrict heights, int count, float z0, float zStep,
                   uint16_t* __restrict out) {
    const float inverse = zStep > 0 ? 1.0f / zStep : 0.0f;
    for (int k = 0; k < count; ++k) {
        const float height = heights[k];
        const float code = (height - z0) * inverse + 0.5f;
        const float low = code > 0.0f ? code : 0.0f;  // NaN becomes 0 here
        const float clamped = low < 65534.0f ? low : 65534.0f;
        const auto rounded = static_cast<int32_t>(clamped);
        const int32_t hole = height == height ? 0 : int32_t{kHolePost};
        out[k] = static_cast<uint16_t>(rounded | hole);
    }
}

}  // namespace terray
