// SPDX-License-Identifier: Apache-2.0
// ray_cast in a program that was built without Vulkan.
#include "device/devices.h"
#include "technique/ray_cast/ray_cast_vk.h"

namespace terray {

Result<std::unique_ptr<DeviceTechnique>> openRayCast(const DeviceRequest&) {
    return listDevices().error();
}

}  // namespace terray
