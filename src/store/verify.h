// SPDX-License-Identifier: Apache-2.0
// Checking every byte of a store against its hashes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"

namespace terray {

struct StoreCheck {
    uint64_t files = 0, tiles = 0, bytes = 0;
    std::vector<std::string> damage;  ///< one line each: which tile or file
};

/// All cores. Error Input if there is no manifest to begin with; Interrupted.
Result<StoreCheck> checkStore(const std::string& path);

}  // namespace terray
