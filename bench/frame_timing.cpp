// SPDX-License-Identifier: Apache-2.0
// Sums and medians of timed frames.
#include "frame_timing.h"

#include "timing.h"

namespace terray::bench {
void addCounters(TraceCounters& sum, const TraceCounters& more) {
    sum.rays += more.rays;
    sum.hits += more.hits;
    sum.steps += more.steps;
    sum.redone += more.redone;
    sum.columns += more.columns;
    sum.beams += more.beams;
}

Timing medianOf(const std::vector<Timing>& timings) {
    std::vector<double> ms, cpuMs;
    for (const Timing& timing : timings) {
        ms.push_back(timing.ms);
        cpuMs.push_back(timing.cpuMs);
    }
    return {median(ms), median(cpuMs)};
}

}  // namespace terray::bench
