// SPDX-License-Identifier: Apache-2.0
// Folders, stores and broken disks for tests of bake.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "bake/bake_store.h"
#include "store/store.h"
#include "stream/test_source.h"

namespace terray::test {

/// An empty folder of its own, removed at the end.
class TestFolder {
public:
    TestFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "terray_bake_XXXXXX").string();
        EXPECT_NE(mkdtemp(name.data()), nullptr);
        path_ = name;
    }
    ~TestFolder() { std::filesystem::remove_all(path_); }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;
    std::string operator/(const std::string& name) const { return path_ + "/" + name; }

private:
    std::string path_;
};

inline std::string contentOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Relative path to bytes, of all files of a folder.
inline std::map<std::string, std::string> filesOf(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        files[std::filesystem::relative(entry.path(), folder).string()] = contentOf(entry.path());
    }
    return files;
}

inline BakePlan planOf(const HeightSource& source, double maxError) {
    BakePlan plan;
    plan.source = &source;
    plan.manifest.info = source.info();
    plan.manifest.maxError = maxError;
    plan.codec = {source.info().format, source.info().z0, source.info().zStep, maxError};
    plan.memoryBytes = uint64_t{64} << 20;
    return plan;
}

/// Counts writes and renames, and fails as told.
class FailingCalls final : public FileCalls {
public:
    ssize_t write(int file, const void* bytes, size_t size) const override {
        const int number = ++writes;
        if (number == interruptAt) {
            errno = EINTR;
            return -1;
        }
        if (failFrom > 0 && number >= failFrom) {
            errno = reason;
            return -1;
        }
        return FileCalls::write(file, bytes, shortWrites ? (size + 1) / 2 : size);
    }
    int rename(const char* from, const char* to) const override {
        const std::lock_guard lock(mutex_);
        const std::filesystem::path path(to);
        ++renamed[(path.parent_path().filename() / path.filename()).string()];
        return FileCalls::rename(from, to);
    }

    mutable std::atomic<int> writes{0};
    mutable std::map<std::string, int> renamed;  ///< by the last two parts of a path
    int failFrom = 0, interruptAt = 0, reason = ENOSPC;
    bool shortWrites = false;

private:
    mutable std::mutex mutex_;
};

inline void bakeWell(const BakePlan& plan, const std::string& out, bool repair = false) {
    const auto outcome = bakeStore(plan, out, repair);
    ASSERT_TRUE(outcome.ok()) << outcome.error().message;
}

}  // namespace terray::test
