// SPDX-License-Identifier: Apache-2.0
// Atomic replacement, appending and reading of a store's files.
#include "store/files.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "dataset/pieces.h"

namespace terray {
namespace {

Error writeError(const std::string& path, int reason) {
    const char* advice = reason == ENOSPC || reason == EDQUOT
                             ? "; free some space and run the same command again: it continues"
                             : "";
    return makeError(ErrorCode::Failed, "'{}' cannot be written: {}{}", path, std::strerror(reason),
                     advice);
}

/// All bytes, whatever pieces the system takes them in. errno on failure, 0 if done.
int writeAll(const FileCalls& calls, int file, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t done = calls.write(file, bytes.data(), bytes.size());
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) return errno;
        if (done == 0) return ENOSPC;
        bytes = bytes.subspan(static_cast<size_t>(done));
    }
    return 0;
}

int syncAll(const FileCalls& calls, int file) {
    while (calls.sync(file) != 0) {
        if (errno != EINTR) return errno;
    }
    return 0;
}

int writeNew(const FileCalls& calls, const std::string& path, std::span<const std::byte> bytes) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0) return errno;
    int reason = writeAll(calls, file, bytes);
    if (reason == 0) reason = syncAll(calls, file);
    if (::close(file) != 0 && reason == 0) reason = errno;
    return reason;
}

}  // namespace

ssize_t FileCalls::write(int file, const void* bytes, size_t size) const {
    return ::write(file, bytes, size);
}
int FileCalls::sync(int file) const { return ::fsync(file); }
int FileCalls::rename(const char* from, const char* to) const { return ::rename(from, to); }

const FileCalls& systemFileCalls() {
    static const FileCalls calls;
    return calls;
}

Result<void> replaceFile(const FileCalls& calls, const std::string& path,
                         std::span<const std::byte> bytes) {
    const std::string temporary = path + ".partial";
    int reason = writeNew(calls, temporary, bytes);
    if (reason == 0 && calls.rename(temporary.c_str(), path.c_str()) != 0) reason = errno;
    if (reason == 0) return {};
    ::unlink(temporary.c_str());
    return writeError(path, reason);
}

Result<std::unique_ptr<AppendFile>> AppendFile::open(const FileCalls& calls, std::string path,
                                                     uint64_t size) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0) return writeError(path, errno);
    std::unique_ptr<AppendFile> out(new AppendFile(calls, std::move(path), file));
    if (::ftruncate(file, static_cast<off_t>(size)) != 0 || ::lseek(file, 0, SEEK_END) < 0) {
        return writeError(out->path_, errno);
    }
    return out;
}

AppendFile::~AppendFile() { ::close(file_); }

Result<void> AppendFile::append(std::span<const std::byte> bytes) {
    int reason = writeAll(calls_, file_, bytes);
    if (reason == 0) reason = syncAll(calls_, file_);
    if (reason != 0) return writeError(path_, reason);
    return {};
}

Result<void> makeFolder(const std::string& path) {
    std::error_code code;
    std::filesystem::create_directories(path, code);
    if (code) {
        return makeError(ErrorCode::Failed, "the folder '{}' cannot be made: {}", path,
                         code.message());
    }
    return {};
}

Result<void> syncFolder(const FileCalls& calls, const std::string& path) {
    const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return writeError(path, errno);
    const int reason = syncAll(calls, folder);
    ::close(folder);
    if (reason != 0 && reason != EINVAL) return writeError(path, reason);  // EINVAL: needs none
    return {};
}

Result<Bytes> readFile(const std::string& path, uint64_t maxBytes) {
    return FilePieces().readAll(path, maxBytes);
}

}  // namespace terray
