// SPDX-License-Identifier: Apache-2.0
// The list of devices in a program that was built without Vulkan.
#include "device/devices.h"
#include "device/look_for.h"

namespace terray {

Result<std::vector<DeviceEntry>> listDevices() {
    return makeError(ErrorCode::Resource,
                     "--device vulkan: this terray was built without Vulkan; use --device cpu, or "
                     "build it with -DTERRAY_VULKAN=ON");
}

Result<void> lookForDevice(const std::string&) { return listDevices().error(); }

uint64_t validationFaults() { return 0; }

}  // namespace terray
