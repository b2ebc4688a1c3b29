// SPDX-License-Identifier: Apache-2.0
// The files of a store as readers get them: by pieces, and only what has the hash that the store
// states. Whatever a disk or a server does, other bytes are an error.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/result.h"
#include "dataset/pieces.h"
#include "store/hashes.h"

namespace terray {

/// hashes.bin, and what readers share. const-shared; stop() and the headers are synchronised.
class StoreFiles {
public:
    /// `hash`: of hashes.bin, as the manifest says. Error Input.
    static Result<std::unique_ptr<StoreFiles>> open(std::string folder, FilePieces& pieces,
                                                    const std::string& hash);

    const std::string& folder() const { return folder_; }
    /// Of one file; error Input if the store knows none of that name.
    Result<FileHashes> hashesOf(const std::string& name) const;
    /// Ends all reads that are under way, and all later ones.
    void stop() const { stop_ = true; }
    const std::atomic<bool>& stopFlag() const { return stop_; }

private:
    friend class CheckedReader;
    StoreFiles() = default;
    std::string textAt(size_t record) const;

    std::string folder_;
    Bytes bytes_;                   ///< of hashes.bin
    std::vector<uint64_t> places_;  ///< of its records, by name
    mutable std::atomic<bool> stop_{false};
    mutable std::mutex mutex_;
    mutable std::unordered_map<std::string, std::shared_ptr<const Bytes>> headers_;
};

/// A file in memory of which only some blocks have been read: what was never read takes no memory.
/// confined.
class FileImage {
public:
    ~FileImage();
    FileImage(const FileImage&) = delete;
    FileImage& operator=(const FileImage&) = delete;
    /// GDAL's name of it.
    const std::string& path() const { return path_; }

private:
    friend class CheckedReader;
    FileImage() = default;
    std::string name_, path_;
    FileHashes hashes_;
    std::vector<bool> isHere_;  ///< per block
    std::byte* data_ = nullptr;
};

/// confined.
class CheckedReader {
public:
    explicit CheckedReader(const StoreFiles& files) : files_(files), pieces_(&files.stopFlag()) {}

    /// The file with all that lies between its blocks.
    Result<std::unique_ptr<FileImage>> open(const std::string& name);
    /// Reads a block, unless it is there.
    Result<void> need(FileImage& image, size_t block);
    /// One block alone. out.size() is its size.
    Result<void> read(const FileHashes& file, size_t block, std::span<std::byte> out);
    Result<Bytes> readAll(const std::string& name);
    /// Bytes of files so far.
    uint64_t bytesRead() const { return bytesRead_; }

private:
    Result<void> readPiece(const std::string& name, BlockRange range, std::span<std::byte> out);
    Error differs(const std::string& name);
    Result<std::shared_ptr<const Bytes>> headerOf(const FileHashes& file);

    const StoreFiles& files_;
    FilePieces pieces_;
    uint64_t bytesRead_ = 0;
};

}  // namespace terray
