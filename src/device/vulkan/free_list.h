// SPDX-License-Identifier: Apache-2.0
// Which parts of a range are free: first fit, neighbours are joined again.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace terray::vulkan {

/// confined.
class FreeList {
public:
    explicit FreeList(uint64_t size) : size_(size) { free_[0] = size; }

    /// Begin of a part of that size, a multiple of `alignment` (a power of two).
    std::optional<uint64_t> take(uint64_t size, uint64_t alignment);
    void give(uint64_t begin, uint64_t size);
    bool isEmpty() const { return free_.size() == 1 && free_.begin()->second == size_; }

private:
    uint64_t size_;
    std::map<uint64_t, uint64_t> free_;  ///< begin -> size
};

}  // namespace terray::vulkan
