// SPDX-License-Identifier: Apache-2.0
// Version of the library.
#pragma once

#include "terray/export.h"

namespace terray {

/// "0.1.0"
TERRAY_API const char* version();

}  // namespace terray
