// SPDX-License-Identifier: Apache-2.0
// The measurements of `terray-bench peers` as Markdown tables.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace terray::bench {

/// One table of builds, and for each number of threads one of primary and one of shadow rays.
std::string markdownTables(const std::vector<nlohmann::json>& lines);

}  // namespace terray::bench
