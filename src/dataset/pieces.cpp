// SPDX-License-Identifier: Apache-2.0
// Files over GDAL's file layer, HTTP over its client.
#include "dataset/pieces.h"

#include <cpl_vsi.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>

#include "base/interrupt.h"
#include "dataset/gdal_handle.h"
#include "dataset/http.h"
#include "dataset/remote.h"

namespace terray {
namespace {

constexpr int kAttempts = 5;  ///< at whole files
constexpr std::chrono::milliseconds kFirstDelay{50}, kNap{20};
constexpr int kDelayGrowth = 4;

}  // namespace

struct FilePieces::State {
    const std::atomic<bool>* stop = nullptr;
    HttpClient http;
    std::string path;  ///< of the open file
    std::unique_ptr<VSILFILE, int (*)(VSILFILE*)> file{nullptr, VSIFCloseL};

    bool mustEnd() const { return isInterrupted() || (stop != nullptr && stop->load()); }
    Error ended() const { return makeError(ErrorCode::Interrupted, "interrupted"); }

    HttpReply get(const std::string& url, const std::string& range, uint64_t most) {
        return http.get(url, range, most, [this] { return mustEnd(); });
    }

    Result<void> readHttp(const std::string& url, uint64_t offset, std::span<std::byte> out) {
        // A server that knows no ranges sends all of the file, which must be cut from.
        constexpr uint64_t kMostUnasked = uint64_t{64} << 20;
        const HttpReply reply = get(url, fmt::format("{}-{}", offset, offset + out.size() - 1),
                                    std::max<uint64_t>(out.size(), kMostUnasked));
        if (mustEnd()) return ended();
        if (!reply.failure.empty()) return makeError(ErrorCode::Input, "{}", reply.failure);
        const uint64_t from = reply.firstByte ? 0 : offset;
        const bool isElsewhere = reply.firstByte && *reply.firstByte != offset;
        const bool isShort = reply.bytes.size() < from + out.size();
        if (isElsewhere || isShort || (reply.firstByte && reply.bytes.size() != out.size())) {
            return makeError(ErrorCode::Input, "the server sends {} bytes in place of {}{}",
                             reply.bytes.size(), out.size(),
                             isElsewhere ? " from another place" : "");
        }
        std::memcpy(out.data(), reply.bytes.data() + from, out.size());
        return {};
    }

    Result<void> readFile(const std::string& name, uint64_t offset, std::span<std::byte> out) {
        clearGdalMessage();
        if (!file || path != name) {
            path = name;
            file.reset(VSIFOpenL(gdalName(name).c_str(), "rb"));
            if (!file) {
                forget(name);
                return makeError(ErrorCode::Input, "it does not exist or is out of reach");
            }
        }
        if (VSIFSeekL(file.get(), offset, SEEK_SET) != 0 ||
            VSIFReadL(out.data(), 1, out.size(), file.get()) != out.size()) {
            forget(name);
            const std::string reason = gdalMessage();
            return makeError(ErrorCode::Input, "{}", reason.empty() ? "it is too short" : reason);
        }
        return {};
    }

    void forget(const std::string& name) {
        if (path == name) file.reset();
        if (isRemote(name)) VSICurlPartialClearCache(gdalName(name).c_str());
    }

    /// False if it is time to end.
    bool pause(std::chrono::milliseconds delay) const {
        const auto end = std::chrono::steady_clock::now() + delay;
        while (std::chrono::steady_clock::now() < end) {
            if (mustEnd()) return false;
            std::this_thread::sleep_for(kNap);
        }
        return true;
    }
};

FilePieces::FilePieces(const std::atomic<bool>* stop) : state_(std::make_unique<State>()) {
    ensureGdal();
    state_->stop = stop;
}
FilePieces::~FilePieces() = default;
FilePieces::FilePieces(FilePieces&&) noexcept = default;
FilePieces& FilePieces::operator=(FilePieces&&) noexcept = default;

Result<void> FilePieces::read(const std::string& path, uint64_t offset, std::span<std::byte> out) {
    if (out.empty()) return {};
    const std::string url = httpUrl(path);
    return url.empty() ? state_->readFile(path, offset, out) : state_->readHttp(url, offset, out);
}

Result<std::vector<std::byte>> FilePieces::readAll(const std::string& path, uint64_t maxBytes) {
    const std::string url = httpUrl(path);
    if (!url.empty()) {
        auto delay = kFirstDelay;
        for (int attempt = 1;; ++attempt, delay *= kDelayGrowth) {
            HttpReply reply = state_->get(url, {}, maxBytes);
            if (state_->mustEnd()) return state_->ended();
            if (reply.failure.empty()) return std::move(reply.bytes);
            if (reply.isPermanent || attempt == kAttempts) {
                return makeError(ErrorCode::Input, "'{}' cannot be read: {}", shownName(path),
                                 reply.failure);
            }
            if (!state_->pause(delay)) return state_->ended();
        }
    }
    VSIStatBufL stat;
    if (VSIStatL(gdalName(path).c_str(), &stat) != 0) {
        forget(path);
        return makeError(ErrorCode::Input, "'{}' does not exist or cannot be reached", path);
    }
    const auto size = static_cast<uint64_t>(stat.st_size);
    if (size > maxBytes) {
        return makeError(ErrorCode::Input, "'{}' has {} bytes, more than the {} that may be there",
                         path, size, maxBytes);
    }
    std::vector<std::byte> bytes(size);
    const Result<void> done = read(path, 0, bytes);
    state_->file.reset();
    if (done) return bytes;
    return makeError(ErrorCode::Input, "'{}' cannot be read: {}", path, done.error().message);
}

void FilePieces::forget(const std::string& path) { state_->forget(path); }

}  // namespace terray
