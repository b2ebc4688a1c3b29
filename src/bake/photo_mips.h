// SPDX-License-Identifier: Apache-2.0
// Halving of photo blocks: means of light, weighed by cover.
#pragma once

#include <cstddef>
#include <cstdint>

namespace terray {

/// From width x height pixels of a 512 x 512 block (straight-alpha sRGB) to half as many, rounded
/// up, rows `stride` bytes apart. Each pixel is the mean of the up to four that it covers.
void halvePhotoBlock(const uint8_t* block, int width, int height, uint8_t* out, ptrdiff_t stride);

}  // namespace terray
