// SPDX-License-Identifier: Apache-2.0
// A buffer and its memory, as a value.
#pragma once

#include <span>

#include "device/vulkan/memory.h"

namespace terray::vulkan {

class Device;

/// Movable; must not outlive its device. confined.
class Buffer {
public:
    Buffer() = default;
    Buffer(Buffer&& other) noexcept { swap(other); }
    Buffer& operator=(Buffer&& other) noexcept {
        swap(other);
        return *this;
    }
    ~Buffer();

    VkBuffer handle() const { return handle_; }
    uint64_t bytes() const { return bytes_; }
    /// What shaders know it by.
    uint64_t address() const { return address_; }
    /// Upload and Readback only. Memory is coherent.
    template <class T>
    std::span<T> mapped() const {
        return {reinterpret_cast<T*>(piece_.mapped), bytes_ / sizeof(T)};
    }

private:
    friend class Device;
    void swap(Buffer& other) noexcept;

    Device* device_ = nullptr;
    VkBuffer handle_ = VK_NULL_HANDLE;
    uint64_t bytes_ = 0, address_ = 0;
    MemoryPiece piece_;
};

}  // namespace terray::vulkan
