// SPDX-License-Identifier: Apache-2.0
// Layouts and pipelines of compute shaders.
#include "device/vulkan/pipeline.h"

namespace terray::vulkan {

Result<std::unique_ptr<ComputePipeline>> ComputePipeline::make(Device& device,
                                                               std::span<const uint32_t> spirv,
                                                               const ShaderInterface& interface) {
    std::unique_ptr<ComputePipeline> pipeline(new ComputePipeline(device));
    TERRAY_TRY(pipeline->create(device.pipelines().handle(), spirv, interface));
    return pipeline;
}

Result<void> ComputePipeline::create(VkPipelineCache cache, std::span<const uint32_t> spirv,
                                     const ShaderInterface& interface) {
    const auto& vk = device_.vk();
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (uint32_t k = 0; k < interface.buffers; ++k)
        bindings.push_back(
            {k, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = interface.buffers;
    set.pBindings = bindings.data();
    VkResult result = vk.vkCreateDescriptorSetLayout(device_.handle(), &set, nullptr, &set_);
    const VkPushConstantRange constants{VK_SHADER_STAGE_COMPUTE_BIT, 0, interface.constantBytes};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set_;
    layout.pushConstantRangeCount = interface.constantBytes > 0 ? 1 : 0;
    layout.pPushConstantRanges = &constants;
    if (result == VK_SUCCESS)
        result = vk.vkCreatePipelineLayout(device_.handle(), &layout, nullptr, &layout_);
    VkShaderModule shader = VK_NULL_HANDLE;
    VkShaderModuleCreateInfo code{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    code.codeSize = spirv.size_bytes();
    code.pCode = spirv.data();
    if (result == VK_SUCCESS)
        result = vk.vkCreateShaderModule(device_.handle(), &code, nullptr, &shader);
    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t k = 0; k < interface.specialization.size(); ++k)
        entries.push_back({k, k * uint32_t{sizeof(uint32_t)}, sizeof(uint32_t)});
    const VkSpecializationInfo special{static_cast<uint32_t>(entries.size()), entries.data(),
                                       entries.size() * sizeof(uint32_t),
                                       interface.specialization.data()};
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = shader;
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &special;
    info.layout = layout_;
    if (result == VK_SUCCESS)
        result =
            vk.vkCreateComputePipelines(device_.handle(), cache, 1, &info, nullptr, &pipeline_);
    vk.vkDestroyShaderModule(device_.handle(), shader, nullptr);
    if (result != VK_SUCCESS)
        return makeError(ErrorCode::Resource, "{} does not take a shader of terray's ({})",
                         device_.name(), nameOf(result));
    return {};
}

ComputePipeline::~ComputePipeline() {
    const auto& vk = device_.vk();
    vk.vkDestroyPipeline(device_.handle(), pipeline_, nullptr);
    vk.vkDestroyPipelineLayout(device_.handle(), layout_, nullptr);
    vk.vkDestroyDescriptorSetLayout(device_.handle(), set_, nullptr);
}

}  // namespace terray::vulkan
