// SPDX-License-Identifier: Apache-2.0
// Recording of copies, barriers and dispatches.
#pragma once

#include <initializer_list>
#include <span>

#include "device/vulkan/device.h"
#include "device/vulkan/pipeline.h"

namespace terray::vulkan {

enum class Stage { Transfer, Compute, Host };

/// One command buffer of the device's ring. confined.
class Commands {
public:
    static Result<std::unique_ptr<Commands>> make(const Device& device);
    ~Commands();
    Commands(const Commands&) = delete;
    Commands& operator=(const Commands&) = delete;

    void copy(const Buffer& from, uint64_t fromByte, const Buffer& to, uint64_t toByte,
              uint64_t bytes);
    /// What `before` has written can be used by `after`, and `after` may overwrite what `before`
    /// has read.
    void barrier(Stage before, Stage after);
    /// Buffers are bound in order, whole; `constants` are the push constants.
    Result<void> dispatch(const ComputePipeline& pipeline,
                          std::initializer_list<const Buffer*> buffers,
                          std::span<const std::byte> constants, uint32_t groups);
    /// Stamps 0 .. Device::kStamps - 1: when all before is done.
    void stamp(uint32_t which);

private:
    friend class Device;
    explicit Commands(const Device& device) : device_(device) {}
    Result<void> create();
    VkResult restart();

    const Device& device_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer buffer_ = VK_NULL_HANDLE;
    VkDescriptorPool sets_ = VK_NULL_HANDLE;
    VkQueryPool stamps_ = VK_NULL_HANDLE;
    Ticket ticket_ = 0;  ///< of its last submission
};

}  // namespace terray::vulkan
