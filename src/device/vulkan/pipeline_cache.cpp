// SPDX-License-Identifier: Apache-2.0
// The file of the pipeline cache: our own header with a checksum before the driver's bytes, because
// drivers do not survive every damage.
#include "device/vulkan/pipeline_cache.h"

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace terray::vulkan {
namespace {

namespace fs = std::filesystem;

struct FileHeader {
    char magic[8] = {'T', 'E', 'R', 'R', 'V', 'K', '0', '1'};
    uint64_t bytes = 0, checksum = 0;
};

/// FNV-1a, 64 bits.
uint64_t checksumOf(std::span<const char> bytes) {
    uint64_t sum = 0xcbf29ce484222325u;
    for (const char byte : bytes) sum = (sum ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
    return sum;
}

/// The driver's own header must name this very driver and device.
bool isOfDevice(std::span<const char> data, const VkPhysicalDeviceProperties& device) {
    VkPipelineCacheHeaderVersionOne header;
    if (data.size() < sizeof(header)) return false;
    std::memcpy(&header, data.data(), sizeof(header));
    return header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
           header.vendorID == device.vendorID && header.deviceID == device.deviceID &&
           std::memcmp(header.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE) == 0;
}

std::vector<char> readFile(const std::string& path, const VkPhysicalDeviceProperties& device) {
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> all{std::istreambuf_iterator<char>(file), {}};
    FileHeader header, wanted;
    if (all.size() < sizeof(header)) return {};
    std::memcpy(&header, all.data(), sizeof(header));
    const std::span<const char> data = std::span(all).subspan(sizeof(header));
    const bool whole = std::memcmp(header.magic, wanted.magic, sizeof(header.magic)) == 0 &&
                       header.bytes == data.size() && header.checksum == checksumOf(data);
    if (!whole || !isOfDevice(data, device)) return {};
    return {data.begin(), data.end()};
}

std::string hexOf(std::span<const uint8_t> bytes) {
    std::string text;
    for (const uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
    return text;
}

}  // namespace

std::string defaultCacheFolder() {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache != nullptr && *cache == '/') return std::string(cache) + "/terray";
    const char* home = std::getenv("HOME");
    if (home != nullptr && *home == '/') return std::string(home) + "/.cache/terray";
    return {};
}

PipelineCache::PipelineCache(const PhysicalDevice& physical, VkDevice device,
                             const VolkDeviceTable& vk, const std::string& folder)
    : physical_(physical), device_(device), vk_(vk) {
    if (!folder.empty()) {
        path_ = folder + "/pipelines-" + hexOf(physical.properties.pipelineCacheUUID) + ".bin";
        read_ = readFile(path_, physical.properties);
    }
    VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    info.initialDataSize = read_.size();
    info.pInitialData = read_.data();
    wasRead_ = !read_.empty() &&
               vk_.vkCreatePipelineCache(device_, &info, nullptr, &handle_) == VK_SUCCESS;
    if (wasRead_) return;
    read_.clear();
    info.initialDataSize = 0;
    if (vk_.vkCreatePipelineCache(device_, &info, nullptr, &handle_) != VK_SUCCESS)
        handle_ = VK_NULL_HANDLE;
}

PipelineCache::~PipelineCache() {
    if (handle_ == VK_NULL_HANDLE) return;
    save();
    vk_.vkDestroyPipelineCache(device_, handle_, nullptr);
}

/// A cache that cannot be written is no harm: the next run compiles again.
void PipelineCache::save() const {
    if (path_.empty()) return;
    size_t bytes = 0;
    if (vk_.vkGetPipelineCacheData(device_, handle_, &bytes, nullptr) != VK_SUCCESS) return;
    std::vector<char> data(bytes);
    if (vk_.vkGetPipelineCacheData(device_, handle_, &bytes, data.data()) != VK_SUCCESS) return;
    data.resize(bytes);
    if (data == read_) return;
    std::error_code ignored;
    fs::create_directories(fs::path(path_).parent_path(), ignored);
    const std::string part = fmt::format("{}.{}", path_, getpid());
    FileHeader header;
    header.bytes = data.size();
    header.checksum = checksumOf(data);
    std::ofstream file(part, std::ios::binary);
    file.write(reinterpret_cast<const char*>(&header), sizeof(header));
    file.write(data.data(), static_cast<std::streamsize>(data.size()));
    file.close();
    if (file)
        fs::rename(part, path_, ignored);
    else
        fs::remove(part, ignored);
}

}  // namespace terray::vulkan
