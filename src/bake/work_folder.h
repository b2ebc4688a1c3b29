// SPDX-License-Identifier: Apache-2.0
// Where a bake writes until it is done: a folder beside the store, a journal of finished files, a
// lock. What is finished survives a killed process.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "base/result.h"
#include "store/files.h"
#include "store/hashes.h"

namespace terray {

/// One bake at a time works on a store: held until destroyed, or until the process dies.
class StoreLock {
public:
    /// Error (Failed) if another process holds it.
    static Result<std::unique_ptr<StoreLock>> take(const std::string& store);
    ~StoreLock();
    StoreLock(const StoreLock&) = delete;
    StoreLock& operator=(const StoreLock&) = delete;

private:
    StoreLock(std::string path, int file) : path_(std::move(path)), file_(file) {}
    std::string path_;
    int file_;
};

/// The unfinished store: NAME.baking/. synchronised.
class WorkFolder {
public:
    /// Whether an earlier bake of this store has left work to go on with.
    static bool hasBegun(const std::string& store);
    /// Makes the folder, or opens the one that an earlier bake of the same plan has left. Files
    /// that the journal names are read again, and forgotten unless they are whole. Error (Failed)
    /// if it belongs to another plan.
    static Result<std::unique_ptr<WorkFolder>> open(const FileCalls& calls,
                                                    const std::string& store,
                                                    const std::string& plan);

    const std::string& path() const { return path_; }
    std::string pathOf(const std::string& file) const { return path_ + "/" + file; }
    /// Files that an earlier run had finished.
    size_t foundFiles() const { return found_; }

    bool isFinished(const std::string& file) const;
    /// Its hashes; null if it is not finished.
    const FileHashes* hashesOf(const std::string& file) const;
    /// Writes a file and, once it is on the disk, its journal entry.
    Result<void> finish(const std::string& file, std::span<const std::byte> bytes,
                        std::vector<BlockRange> blocks);
    /// Takes a finished file over from another folder, as it is.
    Result<void> adopt(const std::string& folder, const FileHashes& hashes);

    /// Puts the folder in the store's place; the store that was there before, the plan and the
    /// journal are removed after that.
    Result<void> publish();
    /// Removes a folder of finished intermediate files.
    Result<void> removeFolder(const std::string& folder);

private:
    WorkFolder(const FileCalls& calls, std::string store)
        : calls_(calls), store_(std::move(store)), path_(store_ + ".baking") {}
    Result<void> readJournal();
    Result<void> note(FileHashes hashes);

    const FileCalls& calls_;
    std::string store_, path_;
    size_t found_ = 0;
    mutable std::mutex mutex_;
    std::map<std::string, FileHashes> finished_;
    std::unique_ptr<AppendFile> journal_;
};

}  // namespace terray
