// SPDX-License-Identifier: Apache-2.0
// The next coarser mip of a photo: means of light, weighed by cover.
#pragma once

#include <cstddef>
#include <cstdint>

namespace terray {

/// Half of the pixels of an image of straight-alpha sRGB, 4 bytes a pixel, rounded up: each the
/// mean of light of the up to four below it, each weighed by its cover. Strides in bytes.
void halvePhoto(const uint8_t* fine, int width, int height, ptrdiff_t fineStride, uint8_t* out,
                ptrdiff_t stride);

}  // namespace terray
