// SPDX-License-Identifier: Apache-2.0
// The list of devices in a program that was built without Vulkan.
#include "device/devices.h"

namespace terray {

Result<std::vector<DeviceEntry>> listDevices() {
    return makeError(ErrorCode::Resource,
                     "this terray was built without Vulkan; use --device cpu, or build it with "
                     "-DTERRAY_VULKAN=ON");
}

}  // namespace terray
