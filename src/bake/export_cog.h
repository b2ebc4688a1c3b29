// SPDX-License-Identifier: Apache-2.0
// A store as one ordinary Cloud Optimized GeoTIFF.
#pragma once

#include <string>

#include "base/result.h"
#include "store/store.h"

namespace terray {

/// Writes mip 0 and, as overviews, the coarser mips into one COG at `path`, within the store's
/// error bound of the store's heights. Sides are padded with holes to n 2^k + 1 posts, so that
/// overviews have the sizes of the nested mips. Needs the disk space of a second, lossless copy
/// beside it meanwhile. Errors: Failed, Input, Interrupted.
Result<void> exportCog(const Store& store, const std::string& path);

}  // namespace terray
