// SPDX-License-Identifier: Apache-2.0
// The staging ring.
#include "device/vulkan/uploader.h"

#include <algorithm>
#include <cstring>

namespace terray::vulkan {

Result<std::unique_ptr<Uploader>> Uploader::make(Device& device, uint64_t partBytes) {
    std::unique_ptr<Uploader> uploader(new Uploader(device));
    for (Buffer& part : uploader->parts_) {
        auto made = device.makeBuffer(partBytes, MemoryKind::Upload);
        if (!made) return made.error();
        part = std::move(*made);
    }
    return uploader;
}

Uploader::~Uploader() {
    if (!device_.isLost()) static_cast<void>(device_.waitIdle());
}

Result<void> Uploader::beginPart() {
    TERRAY_TRY(device_.wait(tickets_[turn_]));
    auto commands = device_.begin();
    if (!commands) return commands.error();
    commands_ = *commands;
    // Shaders may still read, and copies write, what is overwritten.
    commands_->barrier(Stage::Compute, Stage::Transfer);
    commands_->barrier(Stage::Transfer, Stage::Transfer);
    used_ = 0;
    return {};
}

Result<void> Uploader::put(std::span<const std::byte> bytes, const Buffer& to, uint64_t toByte) {
    while (!bytes.empty()) {
        if (commands_ == nullptr) TERRAY_TRY(beginPart());
        const Buffer& part = parts_[turn_];
        const uint64_t count = std::min<uint64_t>(bytes.size(), part.bytes() - used_);
        std::memcpy(part.mapped<std::byte>().data() + used_, bytes.data(), count);
        commands_->copy(part, used_, to, toByte, count);
        used_ += count;
        toByte += count;
        uploaded_ += count;
        bytes = bytes.subspan(count);
        if (used_ == part.bytes()) TERRAY_TRY(flush());
    }
    return {};
}

Result<void> Uploader::flush() {
    if (commands_ == nullptr) return {};
    commands_->barrier(Stage::Transfer, Stage::Compute);
    commands_ = nullptr;
    const auto ticket = device_.submit();
    if (!ticket) return ticket.error();
    tickets_[turn_] = *ticket;
    turn_ = (turn_ + 1) % kParts;
    return {};
}

}  // namespace terray::vulkan
