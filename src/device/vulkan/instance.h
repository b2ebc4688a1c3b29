// SPDX-License-Identifier: Apache-2.0
// The Vulkan instance: headless, with the validation layer on request.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "device/vulkan/vk.h"

namespace terray::vulkan {

/// What the validation layer has found fault with. synchronised.
class Messages {
public:
    void add(std::string text);
    std::vector<std::string> all() const;

private:
    mutable std::mutex mutex_;
    std::vector<std::string> texts_;
};

/// One for the process, and one that validates; they stay until it ends, since drivers that are
/// loaded and unloaded again and again lose memory. const-shared.
class Instance {
public:
    /// `validation`: with core and synchronisation checks. Error Resource when there is no loader,
    /// or no validation layer to be had.
    static Result<const Instance*> of(bool validation);
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    VkInstance handle() const { return handle_; }
    std::vector<std::string> messages() const { return messages_.all(); }

private:
    Instance() = default;
    Result<void> create(bool validation);
    Result<void> listen();

    VkInstance handle_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    Messages messages_;
};

/// Whether the environment asks for validation (TERRAY_VULKAN_VALIDATION=1).
bool wantsValidation();

}  // namespace terray::vulkan
