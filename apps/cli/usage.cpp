// SPDX-License-Identifier: Apache-2.0
// Wording of usage errors.
#include "usage.h"

#include <fmt/format.h>

#include <algorithm>

namespace terray::cli {

void fail(ErrorCode code, std::string message) { throw Failure(Error{code, std::move(message)}); }

void failUsage(std::string message) { fail(ErrorCode::Usage, std::move(message)); }

std::string unmarked(std::string token) {
    std::replace(token.begin(), token.end(), kMinusMark, '-');
    return token;
}

std::string oneLine(std::string message) {
    for (char& c : message)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return message;
}

std::vector<std::string> markNegativeNumbers(std::vector<std::string> arguments) {
    for (std::string& a : arguments) {
        const bool number = a.size() > 1 && a[0] == '-' &&
                            (a[1] == '.' || (a[1] >= '0' && a[1] <= '9')) &&
                            a.find_first_not_of("0123456789.,+-eE") == std::string::npos;
        if (number) a[0] = kMinusMark;
    }
    return arguments;
}

std::string usageMessage(const CLI::ParseError& error, const std::string& command) {
    const std::string help = fmt::format("see '{} --help'", command);
    std::string what = unmarked(error.what());
    std::replace(what.begin(), what.end(), '\n', ' ');
    while (!what.empty() && (what.back() == ' ' || what.back() == '.')) what.pop_back();
    const auto colon = what.find(':');
    switch (static_cast<CLI::ExitCodes>(error.get_exit_code())) {
        case CLI::ExitCodes::ArgumentMismatch:
            return fmt::format("{}: its value is missing; {}", what.substr(0, colon), help);
        case CLI::ExitCodes::RequiredError:
            if (what.find("SOURCE") != std::string::npos)
                return fmt::format("SOURCE is missing: which terrain?; {}", help);
            if (what.find("--flight") != std::string::npos)
                return fmt::format("--flight is missing: which way to fly?; {}", help);
            if (what.find("--output") != std::string::npos && command.ends_with("fly"))
                return fmt::format("-o is missing: what film to make?; {}", help);
            if (what.find("--output") != std::string::npos)
                return fmt::format("-o is missing: where to write the store?; {}", help);
            if (what.find("DEM") != std::string::npos)
                return fmt::format("DEM is missing: what to bake?; {}", help);
            if (what.find("STORE") != std::string::npos)
                return fmt::format("STORE is missing: which store?; {}", help);
            return fmt::format("what to do is missing; {}", help);
        default: return fmt::format("{}; {}", what, help);
    }
}

}  // namespace terray::cli
