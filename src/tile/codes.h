// SPDX-License-Identifier: Apache-2.0
// 16-bit posts to heights and back: z = z0 + zStep * code, rounded once; kHolePost is NaN.
#pragma once

#include <cstdint>

namespace terray {

void decodeCodes(const uint16_t* codes, int count, float z0, float zStep, float* out);
/// The nearest code; heights beyond the codes' range get the first or last one.
void encodeHeights(const float* __restrict heights, int count, float z0, float zStep,
                   uint16_t* __restrict out);

}  // namespace terray
