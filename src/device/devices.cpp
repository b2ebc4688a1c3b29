// SPDX-License-Identifier: Apache-2.0
// The words of --device.
#include "device/devices.h"

namespace terray {

Result<DeviceWish> parseDevice(const std::string& text) {
    if (text == "auto" || text == "cpu") return DeviceWish{};
    if (text == "vulkan") return DeviceWish{true, ""};
    constexpr std::string_view kPrefix = "vulkan:";
    if (text.starts_with(kPrefix) && text.size() > kPrefix.size())
        return DeviceWish{true, text.substr(kPrefix.size())};
    return makeError(ErrorCode::Usage,
                     "--device: '{}' is unknown; give auto, cpu, vulkan, or vulkan:N with a number "
                     "that 'terray devices' lists",
                     text);
}

}  // namespace terray
