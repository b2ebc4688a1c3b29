// SPDX-License-Identifier: Apache-2.0
// Files of a store: written whole under a temporary name, synced and renamed; read whole.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"
#include "store/bytes.h"

namespace terray {

/// The system calls through which stores are written; tests derive from it to inject full disks,
/// short writes and interruptions. const-shared, and so must be what derives from it.
class FileCalls {
public:
    virtual ~FileCalls() = default;
    virtual ssize_t write(int file, const void* bytes, size_t size) const;
    virtual int sync(int file) const;
    virtual int rename(const char* from, const char* to) const;
};
const FileCalls& systemFileCalls();

/// Makes or replaces a file: complete and on the disk when this returns, or as it was before.
/// Error (Failed) names the file and the reason.
Result<void> replaceFile(const FileCalls& calls, const std::string& path,
                         std::span<const std::byte> bytes);

/// A file that grows at its end, each piece on the disk when append() returns. confined.
class AppendFile {
public:
    /// Opens or makes it; cuts what lies beyond `size` bytes.
    static Result<std::unique_ptr<AppendFile>> open(const FileCalls& calls, std::string path,
                                                    uint64_t size);
    ~AppendFile();
    AppendFile(const AppendFile&) = delete;
    AppendFile& operator=(const AppendFile&) = delete;
    Result<void> append(std::span<const std::byte> bytes);

private:
    AppendFile(const FileCalls& calls, std::string path, int file)
        : calls_(calls), path_(std::move(path)), file_(file) {}
    const FileCalls& calls_;
    std::string path_;
    int file_;
};

/// Makes a folder and those above it.
Result<void> makeFolder(const std::string& path);
/// Puts a folder's entries on the disk.
Result<void> syncFolder(const FileCalls& calls, const std::string& path);

/// A whole file over GDAL's file layer (so that URLs work), at most `maxBytes`. Error Input.
Result<Bytes> readFile(const std::string& path, uint64_t maxBytes);

}  // namespace terray
