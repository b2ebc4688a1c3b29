// SPDX-License-Identifier: Apache-2.0
// GDAL's set-up for the whole process, for rooms that never see GDAL itself.
#pragma once

#include <cstdint>

namespace terray {

/// Drivers registered once, errors caught, cache bounded.
void initialiseGdal(uint64_t cacheBytes);

}  // namespace terray
