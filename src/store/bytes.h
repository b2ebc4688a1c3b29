// SPDX-License-Identifier: Apache-2.0
// Little-endian numbers in byte strings, for the files that the store encodes itself.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace terray {

static_assert(std::endian::native == std::endian::little, "posts are copied as they are");

using Bytes = std::vector<std::byte>;

class ByteWriter {
public:
    void text(std::string_view text) { raw(text.data(), text.size()); }
    void number(std::unsigned_integral auto value) { raw(&value, sizeof(value)); }
    void raw(const void* data, size_t size) {
        const auto* from = static_cast<const std::byte*>(data);
        bytes_.insert(bytes_.end(), from, from + size);
    }
    Bytes take() { return std::move(bytes_); }
    std::span<const std::byte> view() const { return bytes_; }

private:
    Bytes bytes_;
};

/// Reads what ByteWriter wrote; a read beyond the end gives zeros and ok() turns false.
class ByteReader {
public:
    explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}
    bool ok() const { return ok_; }
    size_t left() const { return bytes_.size() - at_; }
    template <std::unsigned_integral T>
    T number() {
        T value{};
        raw(&value, sizeof(value));
        return value;
    }
    std::string text(size_t size) {
        if (size > left()) {
            ok_ = false;
            return {};
        }
        std::string out(size, '\0');
        raw(out.data(), size);
        return out;
    }
    void raw(void* out, size_t size) {
        if (size > left()) {
            ok_ = false;
            return;
        }
        std::memcpy(out, bytes_.data() + at_, size);
        at_ += size;
    }
    void skip(size_t size) {
        ok_ = ok_ && size <= left();
        if (ok_) at_ += size;
    }

private:
    std::span<const std::byte> bytes_;
    size_t at_ = 0;
    bool ok_ = true;
};

inline std::span<const std::byte> bytesOf(std::string_view text) {
    return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

}  // namespace terray
