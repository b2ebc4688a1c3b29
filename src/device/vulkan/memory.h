// SPDX-License-Identifier: Apache-2.0
// Device memory: a few large allocations within a budget, handed out in pieces.
#pragma once

#include <cstddef>
#include <list>

#include "device/vulkan/choice.h"
#include "device/vulkan/free_list.h"

namespace terray::vulkan {

enum class MemoryKind {
    Device,    ///< fastest for the device
    Upload,    ///< written by the host, read by the device
    Readback,  ///< written by the device, read by the host through its cache
};

struct MemoryPiece {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint64_t offset = 0, size = 0;
    std::byte* mapped = nullptr;  ///< null unless the host sees it
};

/// confined.
class Memory {
public:
    /// Blocks of this size are asked for, larger ones where a piece is larger.
    static constexpr uint64_t kBlockBytes = uint64_t{32} << 20;

    Memory(const PhysicalDevice& physical, VkDevice device, const VolkDeviceTable& vk,
           uint64_t budgetBytes);
    ~Memory();
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    /// Error Resource when the budget or the device has no more.
    Result<MemoryPiece> take(const VkMemoryRequirements& needs, MemoryKind kind);
    void give(const MemoryPiece& piece);

    uint64_t reservedBytes() const { return reserved_; }  ///< of all blocks
    uint64_t budgetBytes() const { return budget_; }

private:
    struct Block {
        uint32_t type = 0;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        uint64_t size = 0;
        std::byte* mapped = nullptr;
        FreeList free;
    };
    Result<uint32_t> typeFor(uint32_t allowed, MemoryKind kind) const;
    Result<Block*> addBlock(uint32_t type, uint64_t bytes);
    static std::optional<MemoryPiece> takeFrom(Block& block, const VkMemoryRequirements& needs);
    bool isVisible(uint32_t type) const;

    const PhysicalDevice& physical_;
    VkDevice device_;
    const VolkDeviceTable& vk_;
    uint64_t budget_, reserved_ = 0;
    std::list<Block> blocks_;
};

}  // namespace terray::vulkan
