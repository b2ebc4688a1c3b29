// SPDX-License-Identifier: Apache-2.0
// Temporary names, renaming, and sentences for what the file system refuses.
#include "image/partial_file.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

namespace terray {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBufferBytes = 1 << 18;

std::string temporaryName(const fs::path& target) {
    static std::atomic<int> counter{0};
    const std::string name = fmt::format(".{}.partial-{}-{}", target.filename().string(), getpid(),
                                         counter.fetch_add(1));
    return (target.parent_path() / name).string();
}

Error createError(const std::string& target, int reason) {
    const char* advice = reason == ENOENT || reason == ENOTDIR
                             ? "create the folder first, or choose another"
                             : "choose a place that can be written to";
    return makeError(ErrorCode::Failed, "'{}' cannot be written: {}; {}", target,
                     std::strerror(reason), advice);
}

}  // namespace

Result<std::unique_ptr<PartialFile>> PartialFile::create(const std::string& target) {
    std::error_code ignored;
    fs::path place = target;
    if (fs::is_symlink(place, ignored) && fs::exists(place, ignored)) {
        place = fs::canonical(place, ignored);  // the file is replaced, not the link to it
    }
    if (fs::is_directory(place, ignored)) return createError(target, EISDIR);
    const bool direct = fs::exists(place, ignored) && !fs::is_regular_file(place, ignored);
    std::unique_ptr<PartialFile> file(
        new PartialFile(place.string(), direct ? place.string() : temporaryName(place), direct));
    file->stream_ = std::fopen(file->path_.c_str(), "wb");
    if (!file->stream_) {
        const int reason = errno;
        file->published_ = true;  // nothing to remove
        return createError(target, reason);
    }
    std::setvbuf(file->stream_, nullptr, _IOFBF, kBufferBytes);
    return file;
}

PartialFile::~PartialFile() {
    closeStream();
    if (!published_ && !direct_) std::remove(path_.c_str());
}

bool PartialFile::write(const void* bytes, size_t size) {
    if (std::fwrite(bytes, 1, size, stream_) == size) return true;
    keepErrno();
    return false;
}

void PartialFile::keepErrno() {
    if (errno_ == 0) errno_ = errno;
}

void PartialFile::closeStream() {
    if (stream_ && std::fclose(stream_) != 0) keepErrno();
    stream_ = nullptr;
}

Result<void> PartialFile::publish() {
    closeStream();
    if (errno_ != 0) return writeError();
    if (!direct_ && std::rename(path_.c_str(), target_.c_str()) != 0) {
        keepErrno();
        return writeError();
    }
    published_ = true;
    return {};
}

Error PartialFile::writeError(const std::string& detail) const {
    const std::string reason = errno_ != 0 ? std::strerror(errno_) : detail;
    return makeError(ErrorCode::Failed,
                     "writing '{}' failed: {}; free some space or choose another place", target_,
                     reason.empty() ? "unknown reason" : reason);
}

}  // namespace terray
