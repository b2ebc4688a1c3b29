// SPDX-License-Identifier: Apache-2.0
// A logical device with one queue: buffers, command buffers in a ring, a timeline to wait on.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "device/vulkan/buffer.h"
#include "device/vulkan/pipeline_cache.h"

namespace terray::vulkan {

class Commands;

struct DeviceOptions {
    std::string which{};        ///< as in chooseDevice()
    bool validation = false;    ///< see Instance::of()
    uint64_t budgetBytes = 0;   ///< of its memory; 0: half of it
    std::string cacheFolder{};  ///< of compiled pipelines; empty: none are kept
    int submitsUntilLost = -1;  ///< of a test: the device counts as lost after so many; -1: never
};

/// A point on the timeline: reached when all that was submitted before it is done.
using Ticket = uint64_t;

/// confined.
class Device {
public:
    static Result<std::unique_ptr<Device>> open(const DeviceOptions& options);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const PhysicalDevice& physical() const { return physical_; }
    std::string name() const { return physical_.name(); }
    const Instance& instance() const { return *instance_; }
    VkDevice handle() const { return handle_; }
    const VolkDeviceTable& vk() const { return vk_; }
    const Memory& memory() const { return *memory_; }
    PipelineCache& pipelines() { return *pipelines_; }

    Result<Buffer> makeBuffer(uint64_t bytes, MemoryKind kind);

    /// Begins to record; waits if all of the ring are in use. One at a time.
    Result<Commands*> begin();
    /// Submits what begin() gave.
    Result<Ticket> submit();
    Result<void> wait(Ticket ticket);
    Result<void> waitIdle() { return wait(timeline_); }
    /// Milliseconds between two stamps of a submission that is done; none if the queue has no
    /// clock, or the ring has come round.
    std::optional<double> msBetween(Ticket ticket, uint32_t firstStamp, uint32_t lastStamp) const;
    /// Nothing works any more: open another one.
    bool isLost() const { return lost_; }

    static constexpr int kRing = 4;
    static constexpr uint32_t kStamps = 4;

private:
    friend class Buffer;
    Device() = default;
    Result<void> create(const DeviceOptions& options);
    Result<void> createQueue();
    Result<void> createRing();
    /// An Error unless the result is a success; notes that the device is lost.
    Result<void> check(VkResult result, const char* doing);

    const Instance* instance_ = nullptr;
    PhysicalDevice physical_;
    VkDevice handle_ = VK_NULL_HANDLE;
    VolkDeviceTable vk_{};
    VkQueue queue_ = VK_NULL_HANDLE;
    VkSemaphore semaphore_ = VK_NULL_HANDLE;
    std::unique_ptr<Memory> memory_;
    std::unique_ptr<PipelineCache> pipelines_;
    std::array<std::unique_ptr<Commands>, kRing> ring_;
    size_t turn_ = 0;  ///< of the ring: being recorded, or the next to be
    Ticket timeline_ = 0;
    bool lost_ = false;
    int submitsUntilLost_ = -1;
};

}  // namespace terray::vulkan
