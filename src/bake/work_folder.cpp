// SPDX-License-Identifier: Apache-2.0
// Lock, journal and the last rename of a bake.
#include "bake/work_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/log.h"
#include "store/format.h"

namespace terray {
namespace {

namespace fs = std::filesystem;

constexpr const char* kJournal = "journal.bin";
constexpr const char* kPlan = "plan.json";
constexpr uint64_t kMostBytes = uint64_t{1} << 32;

/// The lock that is held may be of a file that its last owner has removed: then it is worth
/// nothing.
bool isStillThere(int file, const std::string& path) {
    struct stat held {
    }, named{};
    return ::fstat(file, &held) == 0 && ::stat(path.c_str(), &named) == 0 &&
           held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

std::string ownerOf(int file) {
    char text[32] = {};
    const ssize_t size = ::pread(file, text, sizeof(text) - 1, 0);
    return size > 0 ? fmt::format(" (process {})", text) : "";
}

std::string asText(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool isThere(const std::string& path) {
    std::error_code ignored;
    return fs::exists(path, ignored);
}

/// A bake that died right after publishing leaves the previous store under the work folder's name.
Result<void> clearLeftOver(const std::string& folder, const std::string& plan) {
    std::error_code code;
    if (!isThere(folder) || isThere(plan)) return {};
    if (isThere(folder + "/" + kManifestName)) {
        fs::remove_all(folder, code);
    } else if (!fs::is_empty(folder, code)) {
        return makeError(ErrorCode::Failed,
                         "'{}' is in the way: it is not an unfinished bake; rename or remove it",
                         folder);
    }
    if (code) {
        return makeError(ErrorCode::Failed, "'{}' cannot be removed: {}", folder, code.message());
    }
    return {};
}

}  // namespace

Result<std::unique_ptr<StoreLock>> StoreLock::take(const std::string& store) {
    const std::string path = store + ".lock";
    while (true) {
        const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (file < 0) {
            return makeError(ErrorCode::Failed, "'{}' cannot be written: {}", path,
                             std::strerror(errno));
        }
        if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
            const std::string owner = ownerOf(file);
            ::close(file);
            return makeError(ErrorCode::Failed,
                             "'{}' is being baked by another process{}; wait until it is done",
                             store, owner);
        }
        if (!isStillThere(file, path)) {
            ::close(file);
            continue;
        }
        const std::string owner = std::to_string(::getpid());
        if (::ftruncate(file, 0) != 0 || ::pwrite(file, owner.data(), owner.size(), 0) < 0) {
            log::detail("'{}' does not say who holds it", path);
        }
        return std::unique_ptr<StoreLock>(new StoreLock(path, file));
    }
}

StoreLock::~StoreLock() {
    ::unlink(path_.c_str());
    ::close(file_);
}

bool WorkFolder::hasBegun(const std::string& store) { return isThere(store + ".baking/" + kPlan); }

Result<std::unique_ptr<WorkFolder>> WorkFolder::open(const FileCalls& calls,
                                                     const std::string& store,
                                                     const std::string& plan) {
    std::unique_ptr<WorkFolder> folder(new WorkFolder(calls, store));
    TERRAY_TRY(clearLeftOver(folder->path_, folder->pathOf(kPlan)));
    TERRAY_TRY(makeFolder(folder->path_));
    const std::string planPath = folder->pathOf(kPlan);
    if (isThere(planPath)) {
        const auto earlier = readFile(planPath, kMostBytes);
        if (!earlier) return earlier.error();
        if (asText(*earlier) != plan) {
            return makeError(
                ErrorCode::Failed,
                "'{}' is an unfinished bake of other or changed sources, or with other "
                "options; finish it with the same command, or remove it",
                folder->path_);
        }
    } else {
        TERRAY_TRY(replaceFile(calls, planPath, bytesOf(plan)));
    }
    TERRAY_TRY(folder->readJournal());
    return folder;
}

/// Entries up to the first torn one count; of those, files that are as the journal says.
Result<void> WorkFolder::readJournal() {
    const std::string path = pathOf(kJournal);
    uint64_t good = 0;
    if (isThere(path)) {
        const auto bytes = readFile(path, kMostBytes);
        if (!bytes) return bytes.error();
        ByteReader in(*bytes);
        for (FileHashes hashes; in.left() > 0 && readRecord(in, hashes);) {
            good = bytes->size() - in.left();
            finished_[hashes.path] = hashes;
        }
    }
    for (auto entry = finished_.begin(); entry != finished_.end();) {
        const auto bytes = readFile(pathOf(entry->first), entry->second.size);
        const bool whole = bytes.ok() && compareFile(entry->second, *bytes).isNone();
        entry = whole ? std::next(entry) : finished_.erase(entry);
    }
    found_ = finished_.size();
    auto journal = AppendFile::open(calls_, path, good);
    if (!journal) return journal.error();
    journal_ = std::move(*journal);
    return {};
}

bool WorkFolder::isFinished(const std::string& file) const { return hashesOf(file) != nullptr; }

const FileHashes* WorkFolder::hashesOf(const std::string& file) const {
    const std::lock_guard lock(mutex_);
    const auto entry = finished_.find(file);
    return entry == finished_.end() ? nullptr : &entry->second;
}

Result<void> WorkFolder::note(FileHashes hashes) {
    ByteWriter record;
    writeRecord(record, hashes);
    const std::lock_guard lock(mutex_);
    TERRAY_TRY(journal_->append(record.view()));
    finished_[hashes.path] = std::move(hashes);
    return {};
}

Result<void> WorkFolder::finish(const std::string& file, std::span<const std::byte> bytes,
                                std::vector<BlockRange> blocks) {
    TERRAY_TRY(makeFolder(fs::path(pathOf(file)).parent_path()));
    TERRAY_TRY(replaceFile(calls_, pathOf(file), bytes));
    return note(hashFile(file, bytes, std::move(blocks)));
}

Result<void> WorkFolder::adopt(const std::string& folder, const FileHashes& hashes) {
    TERRAY_TRY(makeFolder(fs::path(pathOf(hashes.path)).parent_path()));
    const std::string from = folder + "/" + hashes.path, to = pathOf(hashes.path);
    std::error_code code;
    fs::remove(to, code);
    fs::create_hard_link(from, to, code);
    if (code) fs::copy_file(from, to, fs::copy_options::overwrite_existing, code);
    if (code) {
        return makeError(ErrorCode::Failed, "'{}' cannot be taken over from '{}': {}", to, from,
                         code.message());
    }
    return note(hashes);
}

Result<void> WorkFolder::removeFolder(const std::string& folder) {
    std::error_code code;
    fs::remove_all(pathOf(folder), code);
    if (code) {
        return makeError(ErrorCode::Failed, "'{}' cannot be removed: {}", pathOf(folder),
                         code.message());
    }
    return {};
}

Result<void> WorkFolder::publish() {
    journal_.reset();
    for (const auto& entry : fs::recursive_directory_iterator(path_)) {
        if (entry.is_directory()) TERRAY_TRY(syncFolder(calls_, entry.path()));
    }
    TERRAY_TRY(syncFolder(calls_, path_));
    const std::string old = path_ + ".old";
    const bool replaces = isThere(store_);
    const auto fail = [&] {
        return makeError(ErrorCode::Failed, "'{}' cannot be renamed to '{}': {}", path_, store_,
                         std::strerror(errno));
    };
    std::error_code ignored;
    fs::remove_all(old, ignored);
    // One step where the system has it, so that there is a store at any moment.
    if (replaces &&
        ::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, store_.c_str(), RENAME_EXCHANGE) == 0) {
        fs::rename(path_, old, ignored);
    } else {
        if (replaces && calls_.rename(store_.c_str(), old.c_str()) != 0) return fail();
        if (calls_.rename(path_.c_str(), store_.c_str()) != 0) return fail();
    }
    for (const char* file : {kJournal, kPlan}) fs::remove(fs::path(store_) / file, ignored);
    fs::remove_all(old, ignored);
    const fs::path parent = fs::absolute(store_).parent_path();
    return syncFolder(calls_, parent);
}

}  // namespace terray
