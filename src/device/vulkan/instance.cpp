// SPDX-License-Identifier: Apache-2.0
// Loader, layers, instance, and the ear for the validation layer.
#include "device/vulkan/instance.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>

#include "base/log.h"
#include "device/devices.h"

namespace terray::vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

/// volk's global functions are set once for all instances.
std::mutex& loaderMutex() {
    static std::mutex mutex;
    return mutex;
}

std::atomic<uint64_t> faults{0};

VKAPI_ATTR VkBool32 VKAPI_CALL hear(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                    VkDebugUtilsMessageTypeFlagsEXT,
                                    const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    static_cast<Messages*>(user)->add(data->pMessage != nullptr ? data->pMessage : "");
    return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messengerInfo(Messages& messages) {
    VkDebugUtilsMessengerCreateInfoEXT info{
        VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = hear;
    info.pUserData = &messages;
    return info;
}

bool hasValidationLayer() {
    const auto layers = enumerated<VkLayerProperties>([](uint32_t* count, VkLayerProperties* p) {
        vkEnumerateInstanceLayerProperties(count, p);
    });
    return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
        return std::strcmp(layer.layerName, kValidationLayer) == 0;
    });
}

}  // namespace

void Messages::add(std::string text) {
    const std::lock_guard lock(mutex_);
    ++faults;
    texts_.push_back(std::move(text));
    log::warning("Vulkan validation: {}", texts_.back());
}

std::vector<std::string> Messages::all() const {
    const std::lock_guard lock(mutex_);
    return texts_;
}

bool wantsValidation() {
    const char* wish = std::getenv("TERRAY_VULKAN_VALIDATION");
    return wish != nullptr && std::strcmp(wish, "0") != 0 && *wish != '\0';
}

Result<const Instance*> Instance::of(bool validation) {
    static std::array<Instance*, 2> instances{};
    const std::lock_guard lock(loaderMutex());
    Instance*& instance = instances[validation ? 1 : 0];
    if (instance == nullptr) {
        auto* made = new Instance;
        if (const auto created = made->create(validation); !created) {
            delete made;
            return created.error();
        }
        instance = made;
    }
    return instance;
}

Result<void> Instance::create(bool validation) {
    static const VkResult loader = volkInitialize();
    if (loader != VK_SUCCESS)
        return makeError(
            ErrorCode::Resource,
            "--device vulkan: there is no Vulkan loader (libvulkan.so.1) on this machine; install "
            "libvulkan1 and a driver, or use --device cpu");
    if (volkGetInstanceVersion() < VK_API_VERSION_1_3)
        return makeError(ErrorCode::Resource,
                         "--device vulkan: the Vulkan loader of this machine is older than 1.3; "
                         "update libvulkan1, "
                         "or use --device cpu");
    if (validation && !hasValidationLayer())
        return makeError(ErrorCode::Resource,
                         "TERRAY_VULKAN_VALIDATION: the layer {} is missing; install "
                         "vulkan-validationlayers",
                         kValidationLayer);
    VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    app.pApplicationName = "terray";
    app.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &app;
    constexpr std::array kExtra{VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    features.enabledValidationFeatureCount = kExtra.size();
    features.pEnabledValidationFeatures = kExtra.data();
    const VkDebugUtilsMessengerCreateInfoEXT messenger = messengerInfo(messages_);
    features.pNext = &messenger;  // hears of faults in creating and destroying the instance too
    constexpr std::array kExtensions{VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
    if (validation) {
        info.pNext = &features;
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &kValidationLayer;
        info.enabledExtensionCount = kExtensions.size();
        info.ppEnabledExtensionNames = kExtensions.data();
    }
    const VkResult made = vkCreateInstance(&info, nullptr, &handle_);
    if (made != VK_SUCCESS)
        return makeError(ErrorCode::Resource,
                         "--device vulkan: Vulkan does not start ({}): no driver is installed, or "
                         "it is broken; use "
                         "--device cpu",
                         nameOf(made));
    volkLoadInstanceOnly(handle_);
    return validation ? listen() : Result<void>{};
}

Result<void> Instance::listen() {
    // Not volk's global one: that is null as soon as an instance without the extension is made.
    const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(handle_, "vkCreateDebugUtilsMessengerEXT"));
    const VkDebugUtilsMessengerCreateInfoEXT info = messengerInfo(messages_);
    const VkResult made = create(handle_, &info, nullptr, &messenger_);
    if (made != VK_SUCCESS)
        return makeError(ErrorCode::Resource, "the Vulkan validation layer does not report ({})",
                         nameOf(made));
    return {};
}

}  // namespace terray::vulkan

namespace terray {

uint64_t validationFaults() { return vulkan::faults; }

}  // namespace terray
