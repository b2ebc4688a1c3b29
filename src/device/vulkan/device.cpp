// SPDX-License-Identifier: Apache-2.0
// Opening devices, buffers, submitting and waiting.
#include "device/vulkan/device.h"

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "device/vulkan/commands.h"

namespace terray::vulkan {

Buffer::~Buffer() {
    if (handle_ == VK_NULL_HANDLE) return;
    device_->vk_.vkDestroyBuffer(device_->handle_, handle_, nullptr);
    device_->memory_->give(piece_);
}

void Buffer::swap(Buffer& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    std::swap(bytes_, other.bytes_);
    std::swap(address_, other.address_);
    std::swap(piece_, other.piece_);
}

Result<std::unique_ptr<Device>> Device::open(const DeviceOptions& options) {
    std::unique_ptr<Device> device(new Device);
    TERRAY_TRY(device->create(options));
    return device;
}

Result<void> Device::create(const DeviceOptions& options) {
    const auto instance = Instance::of(options.validation);
    if (!instance) return instance.error();
    instance_ = *instance;
    const auto devices = physicalDevices(*instance_);
    auto chosen = chooseDevice(devices, options.which);
    if (!chosen) return chosen.error();
    physical_ = *chosen;
    submitsUntilLost_ = options.submitsUntilLost;
    TERRAY_TRY(createQueue());
    const uint64_t budget =
        options.budgetBytes > 0 ? options.budgetBytes : physical_.memoryBytes() / 2;
    memory_ = std::make_unique<Memory>(physical_, handle_, vk_, budget);
    pipelines_ = std::make_unique<PipelineCache>(physical_, handle_, vk_, options.cacheFolder);
    return createRing();
}

Result<void> Device::createQueue() {
    RequiredFeatures features;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = physical_.queueFamily;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features.base};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    TERRAY_TRY(check(vkCreateDevice(physical_.handle, &info, nullptr, &handle_), "opening it"));
    volkLoadDeviceTable(&vk_, handle_);
    vk_.vkGetDeviceQueue(handle_, physical_.queueFamily, 0, &queue_);
    return {};
}

Result<void> Device::createRing() {
    VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    TERRAY_TRY(check(vk_.vkCreateSemaphore(handle_, &info, nullptr, &semaphore_), "opening it"));
    for (auto& commands : ring_) {
        auto made = Commands::make(*this);
        if (!made) return made.error();
        commands = std::move(*made);
    }
    return {};
}

Device::~Device() {
    if (handle_ == VK_NULL_HANDLE) return;
    vk_.vkDeviceWaitIdle(handle_);
    for (auto& commands : ring_) commands.reset();
    pipelines_.reset();
    memory_.reset();
    vk_.vkDestroySemaphore(handle_, semaphore_, nullptr);
    vk_.vkDestroyDevice(handle_, nullptr);
}

Result<void> Device::check(VkResult result, const char* doing) {
    if (result == VK_SUCCESS) return {};
    if (result == VK_ERROR_DEVICE_LOST) lost_ = true;
    return makeError(ErrorCode::Resource, "{} failed while {} ({})", name(), doing, nameOf(result));
}

Result<Buffer> Device::makeBuffer(uint64_t bytes, MemoryKind kind) {
    TERRAY_ASSERT(bytes > 0);
    if (bytes > physical_.largestBuffer)
        return makeError(ErrorCode::Resource, "{} has no buffers of {:.0f} MiB", name(),
                         static_cast<double>(bytes) / 1048576.0);
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    VkBuffer handle = VK_NULL_HANDLE;
    TERRAY_TRY(check(vk_.vkCreateBuffer(handle_, &info, nullptr, &handle), "making a buffer"));
    VkMemoryRequirements needs;
    vk_.vkGetBufferMemoryRequirements(handle_, handle, &needs);
    auto piece = memory_->take(needs, kind);
    if (!piece) {
        vk_.vkDestroyBuffer(handle_, handle, nullptr);
        return piece.error();
    }
    Buffer buffer;
    buffer.device_ = this;
    buffer.handle_ = handle;
    buffer.bytes_ = bytes;
    buffer.piece_ = *piece;
    TERRAY_TRY(check(vk_.vkBindBufferMemory(handle_, handle, piece->memory, piece->offset),
                     "making a buffer"));
    const VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, nullptr,
                                            handle};
    buffer.address_ = vk_.vkGetBufferDeviceAddress(handle_, &address);
    return buffer;
}

Result<Commands*> Device::begin() {
    Commands& commands = *ring_[turn_];
    TERRAY_TRY(wait(commands.ticket_));
    TERRAY_TRY(check(commands.restart(), "recording"));
    return &commands;
}

Result<Ticket> Device::submit() {
    Commands& commands = *ring_[turn_];
    TERRAY_TRY(check(vk_.vkEndCommandBuffer(commands.buffer_), "recording"));
    if (submitsUntilLost_ >= 0 && submitsUntilLost_-- == 0)
        if (auto lost = check(VK_ERROR_DEVICE_LOST, "submitting"); !lost) return lost.error();
    VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
    buffer.commandBuffer = commands.buffer_;
    VkSemaphoreSubmitInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
    signal.semaphore = semaphore_;
    signal.value = timeline_ + 1;
    signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
    info.commandBufferInfoCount = 1;
    info.pCommandBufferInfos = &buffer;
    info.signalSemaphoreInfoCount = 1;
    info.pSignalSemaphoreInfos = &signal;
    TERRAY_TRY(check(vk_.vkQueueSubmit2(queue_, 1, &info, VK_NULL_HANDLE), "submitting"));
    commands.ticket_ = ++timeline_;
    turn_ = (turn_ + 1) % ring_.size();
    return commands.ticket_;
}

Result<void> Device::wait(Ticket ticket) {
    VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
    info.semaphoreCount = 1;
    info.pSemaphores = &semaphore_;
    info.pValues = &ticket;
    return check(vk_.vkWaitSemaphores(handle_, &info, UINT64_MAX), "waiting");
}

std::optional<double> Device::msBetween(Ticket ticket, uint32_t firstStamp,
                                        uint32_t lastStamp) const {
    if (physical_.timestampBits == 0) return std::nullopt;
    const auto commands = std::find_if(ring_.begin(), ring_.end(),
                                       [&](const auto& c) { return c->ticket_ == ticket; });
    if (commands == ring_.end()) return std::nullopt;
    std::array<uint64_t, kStamps> stamps{};
    const auto read = [&](uint32_t which) {
        return vk_.vkGetQueryPoolResults(handle_, (*commands)->stamps_, which, 1, sizeof(uint64_t),
                                         &stamps[which], sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
    };
    if (read(firstStamp) != VK_SUCCESS || read(lastStamp) != VK_SUCCESS) return std::nullopt;
    const uint64_t mask =
        physical_.timestampBits < 64 ? (uint64_t{1} << physical_.timestampBits) - 1 : UINT64_MAX;
    const uint64_t ticks = (stamps[lastStamp] - stamps[firstStamp]) & mask;
    return static_cast<double>(ticks) *
           static_cast<double>(physical_.properties.limits.timestampPeriod) * 1e-6;
}

}  // namespace terray::vulkan
