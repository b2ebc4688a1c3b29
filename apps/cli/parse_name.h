// SPDX-License-Identifier: Apache-2.0
// parseName(): names of enumerations.
#pragma once

#include <fmt/format.h>

#include <string>

#include "usage.h"

namespace terray::cli {

template <class Table>
auto parseName(const std::string& option, const std::string& text, const Table& table) {
    std::string known;
    for (const auto& [name, value] : table) {
        if (text == name) return value;
        known += (known.empty() ? "" : ", ") + std::string(name);
    }
    failUsage(fmt::format("{}: '{}' is unknown; give one of {}", option, unmarked(text), known));
}

}  // namespace terray::cli
