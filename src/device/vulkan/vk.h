// SPDX-License-Identifier: Apache-2.0
// Vulkan's C API through volk: functions of instances are global, those of a device are in its
// table.
#pragma once

#include <volk.h>

#include <vector>

#include "base/result.h"

namespace terray::vulkan {

/// The name of a result, e.g. "VK_ERROR_DEVICE_LOST".
const char* nameOf(VkResult result);

/// A vkEnumerate or vkGet call with a count and an array, done twice.
template <class T, class Call>
std::vector<T> enumerated(Call call) {
    uint32_t count = 0;
    call(&count, static_cast<T*>(nullptr));
    std::vector<T> items(count);
    call(&count, items.data());
    items.resize(count);
    return items;
}

}  // namespace terray::vulkan
