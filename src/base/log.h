// SPDX-License-Identifier: Apache-2.0
// Words to the user on stderr: notes (what was assumed), warnings, errors. Quiet hides notes.
#pragma once

#include <fmt/format.h>

#include <string>

namespace terray::log {

enum class Verbosity { Quiet, Normal, Verbose };

/// Quiet: warnings and errors only. Normal: notes too. Synchronised.
void setVerbosity(Verbosity verbosity);

/// While one lives, each note and warning is written once, however often it is said: frames of one
/// flight say the same. Synchronised.
class SayOnce {
public:
    SayOnce();
    ~SayOnce();
    SayOnce(const SayOnce&) = delete;
    SayOnce& operator=(const SayOnce&) = delete;
};

void writeNote(const std::string& text);
void writeWarning(const std::string& text);
void writeDetail(const std::string& text);  ///< only shown when Verbose

template <class... Args>
void note(fmt::format_string<Args...> format, Args&&... args) {
    writeNote(fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void warning(fmt::format_string<Args...> format, Args&&... args) {
    writeWarning(fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void detail(fmt::format_string<Args...> format, Args&&... args) {
    writeDetail(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace terray::log
