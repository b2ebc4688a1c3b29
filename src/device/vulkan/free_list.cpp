// SPDX-License-Identifier: Apache-2.0
// First fit, and joining what is given back.
#include "device/vulkan/free_list.h"

#include <iterator>

#include "base/assert.h"

namespace terray::vulkan {

std::optional<uint64_t> FreeList::take(uint64_t size, uint64_t alignment) {
    for (auto it = free_.begin(); it != free_.end(); ++it) {
        const uint64_t begin = (it->first + alignment - 1) / alignment * alignment;
        const uint64_t end = it->first + it->second;
        if (begin + size > end) continue;
        const uint64_t first = it->first;
        free_.erase(it);
        if (begin > first) free_[first] = begin - first;
        if (begin + size < end) free_[begin + size] = end - (begin + size);
        return begin;
    }
    return std::nullopt;
}

void FreeList::give(uint64_t begin, uint64_t size) {
    auto next = free_.lower_bound(begin);
    TERRAY_ASSERT(next == free_.end() || begin + size <= next->first);
    if (next != free_.end() && begin + size == next->first) {
        size += next->second;
        next = free_.erase(next);
    }
    if (next != free_.begin()) {
        const auto before = std::prev(next);
        TERRAY_ASSERT(before->first + before->second <= begin);
        if (before->first + before->second == begin) {
            before->second += size;
            return;
        }
    }
    free_[begin] = size;
}

}  // namespace terray::vulkan
