// SPDX-License-Identifier: Apache-2.0
// Physical devices, what they lack, and which one is meant.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "device/vulkan/instance.h"

namespace terray::vulkan {

struct PhysicalDevice {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    VkPhysicalDeviceProperties properties{};
    VkPhysicalDeviceMemoryProperties memory{};
    uint64_t largestAllocation = 0, largestBuffer = 0;
    uint32_t queueFamily = 0;  ///< does compute
    uint32_t timestampBits = 0;
    std::string lacks;  ///< in words; empty: it can be used

    std::string name() const { return properties.deviceName; }
    std::string kind() const;
    /// Of the largest heap that is the device's own.
    uint64_t memoryBytes() const;
};

/// Discrete GPUs first, then integrated, virtual, CPUs; as the driver lists them within a kind.
std::vector<PhysicalDevice> physicalDevices(const Instance& instance);

/// The device of that number, or the first usable one with that in its name; "": the first usable
/// one. Error Resource with what is wrong.
Result<PhysicalDevice> chooseDevice(std::span<const PhysicalDevice> devices,
                                    const std::string& which);

/// The features that are used, to be asked for; a chain that points into itself.
struct RequiredFeatures {
    RequiredFeatures();
    RequiredFeatures(const RequiredFeatures&) = delete;
    RequiredFeatures& operator=(const RequiredFeatures&) = delete;

    struct Line {
        const char* name;
        VkBool32* value;
    };
    std::vector<Line> lines();

    VkPhysicalDeviceFeatures2 base{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
};

}  // namespace terray::vulkan
