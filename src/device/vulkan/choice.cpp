// SPDX-License-Identifier: Apache-2.0
// Listing, judging and choosing physical devices.
#include "device/vulkan/choice.h"

#include <algorithm>
#include <charconv>

#include "device/devices.h"
#include "device/look_for.h"

namespace terray::vulkan {
namespace {

int rankOf(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return 0;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return 1;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return 2;
        case VK_PHYSICAL_DEVICE_TYPE_CPU: return 3;
        default: return 4;
    }
}

/// Names of required features that are missing, with commas.
std::string missingFeatures(VkPhysicalDevice device) {
    RequiredFeatures features;
    for (const auto& line : features.lines()) *line.value = VK_FALSE;
    vkGetPhysicalDeviceFeatures2(device, &features.base);
    std::string missing;
    for (const auto& line : features.lines())
        if (*line.value == VK_FALSE)
            missing += (missing.empty() ? "" : ", ") + std::string(line.name);
    return missing;
}

bool findQueue(PhysicalDevice& device) {
    const auto families =
        enumerated<VkQueueFamilyProperties>([&](uint32_t* count, VkQueueFamilyProperties* p) {
            vkGetPhysicalDeviceQueueFamilyProperties(device.handle, count, p);
        });
    for (uint32_t k = 0; k < families.size(); ++k) {
        if ((families[k].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) continue;
        device.queueFamily = k;
        device.timestampBits = families[k].timestampValidBits;
        return true;
    }
    return false;
}

PhysicalDevice describe(VkPhysicalDevice handle) {
    PhysicalDevice device;
    device.handle = handle;
    vkGetPhysicalDeviceProperties(handle, &device.properties);
    vkGetPhysicalDeviceMemoryProperties(handle, &device.memory);
    const uint32_t version = device.properties.apiVersion;
    if (version < VK_API_VERSION_1_3) {
        device.lacks = fmt::format("Vulkan 1.3 (its driver has {}.{})",
                                   VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version));
        return device;
    }
    VkPhysicalDeviceMaintenance4Properties v4{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES};
    VkPhysicalDeviceMaintenance3Properties v3{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, &v4};
    VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &v3};
    vkGetPhysicalDeviceProperties2(handle, &all);
    device.largestAllocation = v3.maxMemoryAllocationSize;
    device.largestBuffer = v4.maxBufferSize;
    device.lacks = findQueue(device) ? missingFeatures(handle) : "a queue for compute shaders";
    return device;
}

std::string listOf(std::span<const PhysicalDevice> devices) {
    std::string text;
    for (size_t k = 0; k < devices.size(); ++k)
        text += fmt::format("{}{} {}", k > 0 ? ", " : "", k, devices[k].name());
    return text;
}

}  // namespace

RequiredFeatures::RequiredFeatures() {
    base.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    base.pNext = &v12;
    v12.pNext = &v13;
    for (const auto& line : lines()) *line.value = VK_TRUE;
}

std::vector<RequiredFeatures::Line> RequiredFeatures::lines() {
    return {
        {"bufferDeviceAddress", &v12.bufferDeviceAddress},
        {"hostQueryReset", &v12.hostQueryReset},
        {"timelineSemaphore", &v12.timelineSemaphore},
        {"synchronization2", &v13.synchronization2},
        {"maintenance4", &v13.maintenance4},  // work group sizes in SPIR-V 1.6
    };
}

std::string PhysicalDevice::kind() const {
    constexpr const char* kKinds[] = {"discrete GPU", "integrated GPU", "virtual GPU", "CPU",
                                      "other"};
    return kKinds[rankOf(properties.deviceType)];
}

uint64_t PhysicalDevice::memoryBytes() const {
    uint64_t most = 0;
    for (uint32_t k = 0; k < memory.memoryHeapCount; ++k)
        if ((memory.memoryHeaps[k].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0)
            most = std::max<uint64_t>(most, memory.memoryHeaps[k].size);
    return most;
}

std::vector<PhysicalDevice> physicalDevices(const Instance& instance) {
    const auto handles =
        enumerated<VkPhysicalDevice>([&](uint32_t* count, VkPhysicalDevice* devices) {
            vkEnumeratePhysicalDevices(instance.handle(), count, devices);
        });
    std::vector<PhysicalDevice> devices;
    for (VkPhysicalDevice handle : handles) devices.push_back(describe(handle));
    std::stable_sort(devices.begin(), devices.end(), [](const auto& a, const auto& b) {
        return rankOf(a.properties.deviceType) < rankOf(b.properties.deviceType);
    });
    return devices;
}

Result<PhysicalDevice> chooseDevice(std::span<const PhysicalDevice> devices,
                                    const std::string& which) {
    if (devices.empty())
        return makeError(ErrorCode::Resource,
                         "--device vulkan: there is no Vulkan device on this machine; install a "
                         "driver (mesa-vulkan-drivers has one for CPUs), or use --device cpu");
    size_t number = devices.size();
    const auto [end, fault] = std::from_chars(which.data(), which.data() + which.size(), number);
    const bool isNumber = fault == std::errc{} && end == which.data() + which.size();
    const PhysicalDevice* unfit = nullptr;
    for (size_t k = 0; k < devices.size(); ++k) {
        const bool meant =
            isNumber ? k == number : devices[k].name().find(which) != std::string::npos;
        if (!meant) continue;
        if (devices[k].lacks.empty()) return devices[k];
        if (unfit == nullptr) unfit = &devices[k];
    }
    if (unfit != nullptr)
        return makeError(ErrorCode::Resource,
                         "--device vulkan: {} lacks {}; update its driver, or use --device cpu",
                         unfit->name(), unfit->lacks);
    return makeError(ErrorCode::Resource,
                     "--device vulkan:{}: there is no such device; there are: {}", which,
                     listOf(devices));
}

}  // namespace terray::vulkan

namespace terray {

Result<std::vector<DeviceEntry>> listDevices() {
    const auto instance = vulkan::Instance::of(vulkan::wantsValidation());
    if (!instance) return instance.error();
    std::vector<DeviceEntry> entries;
    for (const auto& device : vulkan::physicalDevices(**instance))
        entries.push_back({device.name(), device.kind(), device.lacks});
    if (entries.empty()) return vulkan::chooseDevice({}, "").error();
    return entries;
}

Result<void> lookForDevice(const std::string& which) {
    const auto instance = vulkan::Instance::of(vulkan::wantsValidation());
    if (!instance) return instance.error();
    const auto chosen = vulkan::chooseDevice(vulkan::physicalDevices(**instance), which);
    return chosen ? Result<void>{} : chosen.error();
}

}  // namespace terray
