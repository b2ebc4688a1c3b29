// SPDX-License-Identifier: Apache-2.0
// Pieces of files, near or far. What comes over HTTP goes through no cache, so that nothing that a
// server said wrongly is kept; a stalled read ends with Ctrl-C.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"

namespace terray {

/// confined; keeps a connection or the last file open.
class FilePieces {
public:
    /// Reads end early, with an error, once `stop` is true; it must outlive this.
    explicit FilePieces(const std::atomic<bool>* stop = nullptr);
    ~FilePieces();
    FilePieces(FilePieces&&) noexcept;
    FilePieces& operator=(FilePieces&&) noexcept;

    /// Bytes [offset, offset + size) of a file. One request where it is remote. Errors: Input
    /// (the reason alone, no name), Interrupted.
    Result<void> read(const std::string& path, uint64_t offset, std::span<std::byte> out);
    /// A whole file of at most `maxBytes`; a remote one is asked for again if a server fails.
    Result<std::vector<std::byte>> readAll(const std::string& path, uint64_t maxBytes);
    /// Forgets what was read of a file: it was wrong.
    void forget(const std::string& path);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace terray
