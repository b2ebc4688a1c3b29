// SPDX-License-Identifier: Apache-2.0
// The photo of a store, whole, as shading takes it.
#pragma once

#include <string>

#include "raster/photo.h"
#include "store/photo_layer.h"

namespace terray {

/// The finest mip that fits into `maxBytes`; the coarsest one always does. `store`: its path. Uses
/// all cores. Errors: Input, Interrupted.
Result<Photo> loadStoredPhoto(const std::string& store, const PhotoLayer& layer, uint64_t maxBytes);

}  // namespace terray
