// SPDX-License-Identifier: Apache-2.0
// What all timed subcommands share: CPU time and medians.
#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace terray::bench {

/// CPU time of all threads so far: what counts on a busy machine.
inline double cpuMs() { return static_cast<double>(std::clock()) * 1e3 / CLOCKS_PER_SEC; }

/// Of a list that is not empty.
inline double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace terray::bench
