// SPDX-License-Identifier: Apache-2.0
// Wrong usage and failed work, on their way to one line on stderr and an exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "terray/result.h"

namespace terray::cli {

/// Ends a command: thrown inside the command line only.
struct Failure : std::exception {
    explicit Failure(Error why) : error(std::move(why)) {}
    const char* what() const noexcept override { return error.message.c_str(); }
    Error error;
};

[[noreturn]] void failUsage(std::string message);
[[noreturn]] void fail(ErrorCode code, std::string message);

/// The value, or a Failure.
template <class T>
T valueOf(Result<T> result) {
    if (!result) throw Failure(result.error());
    return std::move(result).value();
}
inline void check(const Result<void>& result) {
    if (!result) throw Failure(result.error());
}

/// What CLI11 found wrong, in our words: option, what is wrong, what to do.
std::string usageMessage(const CLI::ParseError& error, const std::string& command);

/// Names of files and bytes of damaged ones may hold anything: control characters become '?'.
std::string oneLine(std::string message);

/// Tokens like -105.5 or -3,4 would be taken for short options: marks them as numbers.
/// parse.h understands the mark.
std::vector<std::string> markNegativeNumbers(std::vector<std::string> arguments);
constexpr char kMinusMark = '\x02';
/// The token as the user wrote it.
std::string unmarked(std::string token);

}  // namespace terray::cli
