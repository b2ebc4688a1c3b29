// SPDX-License-Identifier: Apache-2.0
// Bytes of the host into buffers of the device, through a ring of staging memory.
#pragma once

#include "device/vulkan/commands.h"

namespace terray::vulkan {

/// Must not outlive its device. confined: nobody else may record between put() and flush().
class Uploader {
public:
    /// `partBytes`: of one of the ring's parts; one is filled while the others travel.
    static Result<std::unique_ptr<Uploader>> make(Device& device, uint64_t partBytes);
    /// Waits for what travels.
    ~Uploader();
    Uploader(const Uploader&) = delete;
    Uploader& operator=(const Uploader&) = delete;

    /// Of any size, cut into parts where it must be. What used these bytes of `to` before must be
    /// submitted.
    Result<void> put(std::span<const std::byte> bytes, const Buffer& to, uint64_t toByte);
    /// Submits what is left; compute shaders that are submitted later see all of it.
    Result<void> flush();

    uint64_t uploadedBytes() const { return uploaded_; }

private:
    explicit Uploader(Device& device) : device_(device) {}
    Result<void> beginPart();

    static constexpr size_t kParts = 2;
    Device& device_;
    std::array<Buffer, kParts> parts_;
    std::array<Ticket, kParts> tickets_{};
    size_t turn_ = 0;
    uint64_t used_ = 0;             ///< of the part being filled
    Commands* commands_ = nullptr;  ///< null: no part is being filled
    uint64_t uploaded_ = 0;
};

}  // namespace terray::vulkan
