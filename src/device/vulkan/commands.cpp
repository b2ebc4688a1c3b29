// SPDX-License-Identifier: Apache-2.0
// Command buffers.
#include "device/vulkan/commands.h"

#include "base/assert.h"

namespace terray::vulkan {
namespace {

/// Of one recording.
constexpr uint32_t kMostSets = 16, kMostBuffers = 128;

struct StageMasks {
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 writes, all;
};

StageMasks masksOf(Stage stage) {
    switch (stage) {
        case Stage::Transfer:
            return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                    VK_ACCESS_2_TRANSFER_READ_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT};
        case Stage::Compute:
            return {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_WRITE_BIT,
                    VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_SHADER_WRITE_BIT};
        case Stage::Host: break;
    }
    return {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_WRITE_BIT,
            VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT};
}

}  // namespace

Result<std::unique_ptr<Commands>> Commands::make(const Device& device) {
    std::unique_ptr<Commands> commands(new Commands(device));
    TERRAY_TRY(commands->create());
    return commands;
}

Result<void> Commands::create() {
    const auto& vk = device_.vk();
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device_.physical().queueFamily;
    VkResult result = vk.vkCreateCommandPool(device_.handle(), &pool, nullptr, &pool_);
    VkCommandBufferAllocateInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr,
                                       pool_, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    if (result == VK_SUCCESS)
        result = vk.vkAllocateCommandBuffers(device_.handle(), &buffer, &buffer_);
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, kMostBuffers};
    VkDescriptorPoolCreateInfo sets{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    sets.maxSets = kMostSets;
    sets.poolSizeCount = 1;
    sets.pPoolSizes = &size;
    if (result == VK_SUCCESS)
        result = vk.vkCreateDescriptorPool(device_.handle(), &sets, nullptr, &sets_);
    VkQueryPoolCreateInfo stamps{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    stamps.queryType = VK_QUERY_TYPE_TIMESTAMP;
    stamps.queryCount = Device::kStamps;
    if (result == VK_SUCCESS)
        result = vk.vkCreateQueryPool(device_.handle(), &stamps, nullptr, &stamps_);
    if (result != VK_SUCCESS)
        return makeError(ErrorCode::Resource, "{} has no room for command buffers ({})",
                         device_.name(), nameOf(result));
    return {};
}

Commands::~Commands() {
    const auto& vk = device_.vk();
    vk.vkDestroyQueryPool(device_.handle(), stamps_, nullptr);
    vk.vkDestroyDescriptorPool(device_.handle(), sets_, nullptr);
    vk.vkDestroyCommandPool(device_.handle(), pool_, nullptr);
}

VkResult Commands::restart() {
    const auto& vk = device_.vk();
    vk.vkResetQueryPool(device_.handle(), stamps_, 0, Device::kStamps);
    vk.vkResetDescriptorPool(device_.handle(), sets_, 0);
    if (const VkResult reset = vk.vkResetCommandPool(device_.handle(), pool_, 0);
        reset != VK_SUCCESS)
        return reset;
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    return vk.vkBeginCommandBuffer(buffer_, &info);
}

void Commands::copy(const Buffer& from, uint64_t fromByte, const Buffer& to, uint64_t toByte,
                    uint64_t bytes) {
    TERRAY_ASSERT(fromByte + bytes <= from.bytes() && toByte + bytes <= to.bytes());
    const VkBufferCopy part{fromByte, toByte, bytes};
    device_.vk().vkCmdCopyBuffer(buffer_, from.handle(), to.handle(), 1, &part);
}

void Commands::barrier(Stage before, Stage after) {
    const StageMasks from = masksOf(before), to = masksOf(after);
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    barrier.srcStageMask = from.stages;
    barrier.srcAccessMask = from.writes;
    barrier.dstStageMask = to.stages;
    barrier.dstAccessMask = to.all;
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &barrier;
    device_.vk().vkCmdPipelineBarrier2(buffer_, &info);
}

Result<void> Commands::dispatch(const ComputePipeline& pipeline,
                                std::initializer_list<const Buffer*> buffers,
                                std::span<const std::byte> constants, uint32_t groups) {
    const auto& vk = device_.vk();
    const VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr,
                                           sets_, 1, &pipeline.set_};
    VkDescriptorSet set = VK_NULL_HANDLE;
    if (const VkResult made = vk.vkAllocateDescriptorSets(device_.handle(), &info, &set);
        made != VK_SUCCESS)
        return makeError(ErrorCode::Resource, "{} has no room for a descriptor set ({})",
                         device_.name(), nameOf(made));
    std::vector<VkDescriptorBufferInfo> infos;
    for (const Buffer* buffer : buffers) infos.push_back({buffer->handle(), 0, VK_WHOLE_SIZE});
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set;
    write.descriptorCount = static_cast<uint32_t>(infos.size());
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = infos.data();
    vk.vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
    vk.vkCmdBindPipeline(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline_);
    vk.vkCmdBindDescriptorSets(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout_, 0, 1,
                               &set, 0, nullptr);
    if (!constants.empty())
        vk.vkCmdPushConstants(buffer_, pipeline.layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                              static_cast<uint32_t>(constants.size()), constants.data());
    vk.vkCmdDispatch(buffer_, groups, 1, 1);
    return {};
}

void Commands::stamp(uint32_t which) {
    TERRAY_ASSERT(which < Device::kStamps);
    if (device_.physical().timestampBits == 0) return;
    device_.vk().vkCmdWriteTimestamp2(buffer_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, stamps_,
                                      which);
}

}  // namespace terray::vulkan
