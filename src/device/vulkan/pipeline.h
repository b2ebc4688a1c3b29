// SPDX-License-Identifier: Apache-2.0
// A compute shader, ready to be dispatched.
#pragma once

#include <memory>

#include "device/vulkan/device.h"

namespace terray::vulkan {

struct ShaderInterface {
    uint32_t buffers = 0;        ///< storage buffers, bindings 0 .. buffers - 1 of set 0
    uint32_t constantBytes = 0;  ///< of push constants, at most 128
    std::vector<uint32_t> specialization{};  ///< values of the constants with ids 0, 1, ...
};

/// Must not outlive its device. const-shared.
class ComputePipeline {
public:
    static Result<std::unique_ptr<ComputePipeline>> make(Device& device,
                                                         std::span<const uint32_t> spirv,
                                                         const ShaderInterface& interface);
    ~ComputePipeline();
    ComputePipeline(const ComputePipeline&) = delete;
    ComputePipeline& operator=(const ComputePipeline&) = delete;

private:
    friend class Commands;
    explicit ComputePipeline(const Device& device) : device_(device) {}
    Result<void> create(VkPipelineCache cache, std::span<const uint32_t> spirv,
                        const ShaderInterface& interface);

    const Device& device_;
    VkDescriptorSetLayout set_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace terray::vulkan
