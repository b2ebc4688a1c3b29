// SPDX-License-Identifier: Apache-2.0
// Medians of timed frames.
#include "frame_timing.h"

#include "timing.h"

namespace terray::bench {

Timing medianOf(const std::vector<Timing>& timings) {
    std::vector<double> ms, cpuMs;
    for (const Timing& timing : timings) {
        ms.push_back(timing.ms);
        cpuMs.push_back(timing.cpuMs);
    }
    return {median(ms), median(cpuMs)};
}

}  // namespace terray::bench
