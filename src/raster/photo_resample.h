// SPDX-License-Identifier: Apache-2.0
// Resampling of an RGBA picture through a map: bicubic where all is opaque, else bilinear.
#pragma once

#include <cstdint>

#include "raster/photo.h"
#include "raster/source_map.h"

namespace terray {

/// Straight-alpha RGBA, row-major: the part of a picture that is held in memory.
struct RgbaView {
    const uint8_t* rgba = nullptr;
    int width = 0, height = 0;  ///< of the whole picture
    int heldWidth = 0;          ///< pixels of a held row
    int x = 0, y = 0;           ///< of the first held pixel
};

/// Where resampled pixels go: a window of the lattice, rows `stride` bytes apart.
struct RgbaWindow {
    uint8_t* rgba = nullptr;
    ptrdiff_t stride = 0;
    int64_t column = 0, row = 0, width = 0, height = 0;
};

/// Fills the part of a window that lies in a patch: each pixel is looked up at its place in
/// `source`, which holds what the filter needs there; outside the picture it is 0.
void resamplePatch(const RgbaView& source, const MapPatch& patch, const RgbaWindow& out);

/// Fills photo.rgba (sized already). Uses all cores.
void resamplePhoto(const RgbaView& source, const SourceMap& map, Photo& photo);

}  // namespace terray
