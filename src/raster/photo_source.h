// SPDX-License-Identifier: Apache-2.0
// Photos of any size as PhotoSources: the pixels of loadPhoto() at full resolution, window by
// window.
#pragma once

#include <memory>
#include <string>

#include "raster/photo_plan.h"
#include "terray/options.h"
#include "tile/photo_source.h"

namespace terray {

/// The same lattice and the same pixels as loadPhoto() gives where memory is no bound
/// (place.maxBytes does not count). Errors as there.
Result<std::unique_ptr<PhotoSource>> openPhotoSource(const std::string& path,
                                                     const OpenOptions& options, PhotoPlace place);

}  // namespace terray
