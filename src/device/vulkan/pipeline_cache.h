// SPDX-License-Identifier: Apache-2.0
// Compiled pipelines, kept in a file for the next run.
#pragma once

#include <span>
#include <string>

#include "device/vulkan/choice.h"

namespace terray::vulkan {

/// $XDG_CACHE_HOME/terray or ~/.cache/terray; empty where neither is known.
std::string defaultCacheFolder();

/// confined. Writes its file when it ends, if something is new.
class PipelineCache {
public:
    /// A file that is damaged, or another driver's, counts as none.
    PipelineCache(const PhysicalDevice& physical, VkDevice device, const VolkDeviceTable& vk,
                  const std::string& folder);
    ~PipelineCache();
    PipelineCache(const PipelineCache&) = delete;
    PipelineCache& operator=(const PipelineCache&) = delete;

    VkPipelineCache handle() const { return handle_; }  ///< null if the driver has none
    const std::string& path() const { return path_; }
    bool wasRead() const { return wasRead_; }

private:
    void save() const;

    const PhysicalDevice& physical_;
    VkDevice device_;
    const VolkDeviceTable& vk_;
    VkPipelineCache handle_ = VK_NULL_HANDLE;
    std::string path_;
    bool wasRead_ = false;
    std::vector<char> read_;
};

}  // namespace terray::vulkan
