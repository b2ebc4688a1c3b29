// SPDX-License-Identifier: Apache-2.0
// `terray bench`: becomes terray-bench, which is a program of its own.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "commands.h"
#include "output.h"
#include "usage.h"

namespace terray::cli {
namespace {

constexpr const char* kHelp =
    "terray bench: reproduces the figures in the README\n"
    "Usage: terray bench [ARGUMENTS of terray-bench]\n"
    "\n"
    "Runs terray-bench, which is built with TERRAY_BUILD_BENCH and found beside terray.\n"
    "\n"
    "Example:\n"
    "  terray bench kernel\n";

/// Empty if it is not installed.
std::string findBench() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    for (const fs::path& place : {folder, folder / TERRAY_LIBEXEC_FROM_BIN}) {
        const fs::path program = place / "terray-bench";
        if (access(program.c_str(), X_OK) == 0) return program.string();
    }
    return {};
}

}  // namespace

void addBench(CLI::App& program) {
    program.add_subcommand("bench", "measure: runs terray-bench with the same arguments");
}

int runBench(const std::vector<std::string>& arguments) {
    const std::string program = findBench();
    if (program.empty()) {
        if (arguments.size() == 1 && (arguments[0] == "--help" || arguments[0] == "-h")) {
            printOut(kHelp);
            return 0;
        }
        fail(ErrorCode::Resource,
             "bench: terray-bench is not installed beside terray; build Terray with "
             "-DTERRAY_BUILD_BENCH=ON");
    }
    std::vector<std::string> words = arguments;
    words.insert(words.begin(), program);
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    execv(program.c_str(), pointers.data());
    fail(ErrorCode::Resource, fmt::format("bench: '{}' cannot be run", program));
}

}  // namespace terray::cli
