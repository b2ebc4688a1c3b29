// SPDX-License-Identifier: Apache-2.0
// A file that appears complete or not at all: written under a temporary name, then renamed.
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>

#include "base/result.h"

namespace terray {

/// The file being written beside its target, ".<name>.partial-<pid>-<n>"; destroyed unpublished, it
/// is removed. A target that exists and is no regular file (a device) is written to directly.
/// confined.
class PartialFile {
public:
    /// Error (Failed) if the target cannot be written there.
    static Result<std::unique_ptr<PartialFile>> create(const std::string& target);
    ~PartialFile();
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;

    std::FILE* stream() { return stream_; }
    const std::string& temporaryPath() const { return path_; }
    /// Appends; false on failure, whose reason writeError() keeps.
    bool write(const void* bytes, size_t size);
    /// For libraries that write to temporaryPath() themselves.
    void closeStream();
    /// Closes and renames to the target.
    Result<void> publish();
    /// The sentence for a failed write: errno's reason if one was kept, else `detail`.
    Error writeError(const std::string& detail = "") const;
    void keepErrno();

private:
    PartialFile(std::string target, std::string path, bool direct)
        : target_(std::move(target)), path_(std::move(path)), direct_(direct) {}

    std::string target_, path_;
    bool direct_ = false, published_ = false;
    std::FILE* stream_ = nullptr;
    int errno_ = 0;
};

}  // namespace terray
