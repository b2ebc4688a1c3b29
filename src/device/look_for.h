// SPDX-License-Identifier: Apache-2.0
// What devices.cpp asks of Vulkan, or of its absence.
#pragma once

#include <string>

#include "base/result.h"

namespace terray {

/// An Error that says why --device vulkan:WHICH cannot be had.
Result<void> lookForDevice(const std::string& which);

}  // namespace terray
