// SPDX-License-Identifier: Apache-2.0
// Resampling of an RGBA picture through a map: bicubic where all is opaque, else bilinear.
#pragma once

#include <cstdint>

#include "raster/photo.h"
#include "raster/source_map.h"

namespace terray {

/// Straight-alpha RGBA, row-major.
struct RgbaView {
    const uint8_t* rgba = nullptr;
    int width = 0, height = 0;
};

/// Fills photo.rgba (sized already): each pixel is looked up at its place in `source`; outside the
/// source's pixels it is 0. Uses all cores.
void resamplePhoto(const RgbaView& source, const SourceMap& map, Photo& photo);

}  // namespace terray
