// SPDX-License-Identifier: Apache-2.0
// ray_cast on a Vulkan device.
#pragma once

#include "technique/device_technique.h"

namespace terray {

Result<std::unique_ptr<DeviceTechnique>> openRayCast(const DeviceRequest& request);

}  // namespace terray
