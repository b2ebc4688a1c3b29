// SPDX-License-Identifier: Apache-2.0
// The words of --device.
#include "device/devices.h"

#include <map>
#include <mutex>

#include "device/look_for.h"

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

Result<void> checkDevice(const DeviceWish& wish) {
    if (!wish.vulkan) return {};
    static std::mutex mutex;
    static std::map<std::string, Result<void>> known;
    const std::lock_guard lock(mutex);
    const auto found = known.find(wish.which);
    if (found != known.end()) return found->second;
    const Result<void> result = lookForDevice(wish.which);
    known.emplace(wish.which, result);
    return result;
}

}  // namespace terray
