// SPDX-License-Identifier: Apache-2.0
// Row bookkeeping of the picture writers.
#include "image/banded_writer.h"

#include "base/assert.h"

namespace terray {

size_t BandedWriter::rowBytes() const {
    const size_t sampleBytes = spec_.type == PixelType::Byte ? 1 : sizeof(float);
    return static_cast<size_t>(spec_.width) * static_cast<size_t>(spec_.channels) * sampleBytes;
}

Result<void> BandedWriter::writeRows(std::span<const uint8_t> pixels) {
    const auto bytes = std::as_bytes(pixels);
    return put(PixelType::Byte, bytes.data(), bytes.size());
}

Result<void> BandedWriter::writeRows(std::span<const float> pixels) {
    const auto bytes = std::as_bytes(pixels);
    return put(PixelType::Float, bytes.data(), bytes.size());
}

Result<void> BandedWriter::put([[maybe_unused]] PixelType type, const std::byte* pixels,
                               size_t bytes) {
    TERRAY_ASSERT(type == spec_.type);
    TERRAY_ASSERT(bytes % rowBytes() == 0);
    TERRAY_ASSERT(bytes / rowBytes() <= static_cast<size_t>(spec_.height - rowsWritten_));
    if (failed_) return file_->writeError("an earlier row could not be written");
    const int rows = static_cast<int>(bytes / rowBytes());
    if (rows == 0) return {};
    Result<void> done = putRows(pixels, rowsWritten_, rows);
    failed_ = !done.ok();
    rowsWritten_ += rows;
    return done;
}

Result<void> BandedWriter::finish() {
    TERRAY_ASSERT(rowsWritten_ == spec_.height);
    if (failed_) return file_->writeError("an earlier row could not be written");
    failed_ = true;  // until published: a second finish() is refused
    TERRAY_TRY(close());
    return file_->publish();
}

}  // namespace terray
