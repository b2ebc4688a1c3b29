// SPDX-License-Identifier: Apache-2.0
// Blocks of device memory and the pieces in them.
#include "device/vulkan/memory.h"

#include <algorithm>

#include "base/assert.h"

namespace terray::vulkan {

Memory::Memory(const PhysicalDevice& physical, VkDevice device, const VolkDeviceTable& vk,
               uint64_t budgetBytes)
    : physical_(physical), device_(device), vk_(vk), budget_(budgetBytes) {}

Memory::~Memory() {
    for (const Block& block : blocks_) {
        TERRAY_ASSERT(block.free.isEmpty());
        vk_.vkFreeMemory(device_, block.memory, nullptr);
    }
}

bool Memory::isVisible(uint32_t type) const {
    return (physical_.memory.memoryTypes[type].propertyFlags &
            VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0;
}

Result<uint32_t> Memory::typeFor(uint32_t allowed, MemoryKind kind) const {
    constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    constexpr VkMemoryPropertyFlags kHost =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    constexpr VkMemoryPropertyFlags kCached = kHost | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
    // The best first; every device has memory of the last kind of each line.
    std::vector<VkMemoryPropertyFlags> wishes;
    switch (kind) {
        case MemoryKind::Device: wishes = {kLocal, 0}; break;
        case MemoryKind::Upload: wishes = {kHost}; break;
        case MemoryKind::Readback: wishes = {kCached, kHost}; break;
    }
    for (const VkMemoryPropertyFlags wish : wishes)
        for (uint32_t type = 0; type < physical_.memory.memoryTypeCount; ++type)
            if ((allowed >> type & 1u) != 0 &&
                (physical_.memory.memoryTypes[type].propertyFlags & wish) == wish)
                return type;
    return makeError(ErrorCode::Resource, "{} has no memory of the kind that is needed",
                     physical_.name());
}

std::optional<MemoryPiece> Memory::takeFrom(Block& block, const VkMemoryRequirements& needs) {
    const auto offset = block.free.take(needs.size, needs.alignment);
    if (!offset) return std::nullopt;
    return MemoryPiece{block.memory, *offset, needs.size,
                       block.mapped != nullptr ? block.mapped + *offset : nullptr};
}

Result<MemoryPiece> Memory::take(const VkMemoryRequirements& needs, MemoryKind kind) {
    const auto type = typeFor(needs.memoryTypeBits, kind);
    if (!type) return type.error();
    for (Block& block : blocks_) {
        if (block.type != *type) continue;
        if (auto piece = takeFrom(block, needs)) return *piece;
    }
    const uint64_t room = budget_ - reserved_;
    if (needs.size > room || needs.size > physical_.largestAllocation)
        return makeError(
            ErrorCode::Resource,
            "{} would need {:.0f} MiB more than the {:.0f} MiB of its memory that may "
            "be used",
            physical_.name(),
            static_cast<double>(needs.size) / 1048576.0 -
                static_cast<double>(std::min(room, physical_.largestAllocation)) / 1048576.0,
            static_cast<double>(budget_) / 1048576.0);
    const uint64_t wanted =
        std::min({std::max(kBlockBytes, needs.size), room, physical_.largestAllocation});
    auto block = addBlock(*type, wanted);
    if (!block && wanted > needs.size) block = addBlock(*type, needs.size);
    if (!block) return block.error();
    const auto piece = takeFrom(**block, needs);
    TERRAY_ASSERT(piece);
    return *piece;
}

Result<Memory::Block*> Memory::addBlock(uint32_t type, uint64_t bytes) {
    VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flags, bytes, type};
    VkDeviceMemory memory = VK_NULL_HANDLE;
    VkResult result = vk_.vkAllocateMemory(device_, &info, nullptr, &memory);
    void* mapped = nullptr;
    if (result == VK_SUCCESS && isVisible(type)) {
        result = vk_.vkMapMemory(device_, memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        if (result != VK_SUCCESS) vk_.vkFreeMemory(device_, memory, nullptr);
    }
    if (result != VK_SUCCESS)
        return makeError(ErrorCode::Resource, "{} has not {:.0f} MiB of memory left ({})",
                         physical_.name(), static_cast<double>(bytes) / 1048576.0, nameOf(result));
    reserved_ += bytes;
    blocks_.push_back({type, memory, bytes, static_cast<std::byte*>(mapped), FreeList(bytes)});
    return &blocks_.back();
}

void Memory::give(const MemoryPiece& piece) {
    const auto block = std::find_if(blocks_.begin(), blocks_.end(),
                                    [&](const Block& b) { return b.memory == piece.memory; });
    TERRAY_ASSERT(block != blocks_.end());
    block->free.give(piece.offset, piece.size);
    if (!block->free.isEmpty()) return;
    vk_.vkFreeMemory(device_, block->memory, nullptr);
    reserved_ -= block->size;
    blocks_.erase(block);
}

}  // namespace terray::vulkan
