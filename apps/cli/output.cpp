// SPDX-License-Identifier: Apache-2.0
// Checked writes.
#include "output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "usage.h"

namespace terray::cli {
namespace {

namespace fs = std::filesystem;

/// Devices and pipes have no neighbour to be renamed from.
bool isSpecial(const std::string& path) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

[[noreturn]] void failWrite(const std::string& option, const std::string& path, int problem) {
    fail(ErrorCode::Failed,
         fmt::format("{}: cannot write '{}': {}; choose another place or make room", option, path,
                     std::strerror(problem)));
}

void writeAll(const std::string& option, const std::string& path, const std::string& target,
              const std::string& text) {
    std::FILE* file = std::fopen(target.c_str(), "wb");
    if (file == nullptr) failWrite(option, path, errno);
    const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
    const int problem = errno;
    const bool closed = std::fclose(file) == 0;
    if (written && closed) return;
    const int why = written ? errno : problem;
    if (target != path) std::remove(target.c_str());
    failWrite(option, path, why);
}

}  // namespace

void printOut(const std::string& text) {
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    if (!written || std::fflush(stdout) != 0)
        fail(ErrorCode::Failed,
             fmt::format("cannot write to standard output: {}", std::strerror(errno)));
}

void checkWritable(const std::string& option, const std::string& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) failWrite(option, path, EISDIR);
    if (fs::exists(path, ignored)) {
        if (access(path.c_str(), W_OK) != 0) failWrite(option, path, errno);
        if (isSpecial(path)) return;
    }
    const std::string folder = fs::path(path).parent_path().string();
    if (access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) != 0)
        failWrite(option, path, errno);
}

void checkNotInput(const std::string& option, const std::string& path,
                   const std::vector<std::string>& inputs) {
    for (const std::string& input : inputs) {
        std::error_code ignored;
        if (!path.empty() && fs::is_regular_file(path, ignored) &&
            fs::equivalent(path, input, ignored))
            failUsage(fmt::format("{}: '{}' is an input; write somewhere else", option, path));
    }
}

void writeTextFile(const std::string& option, const std::string& path, const std::string& text) {
    if (isSpecial(path)) return writeAll(option, path, path, text);
    const std::string temporary = fmt::format("{}.{}.tmp", path, getpid());
    writeAll(option, path, temporary, text);
    if (std::rename(temporary.c_str(), path.c_str()) == 0) return;
    const int problem = errno;
    std::remove(temporary.c_str());
    failWrite(option, path, problem);
}

}  // namespace terray::cli
