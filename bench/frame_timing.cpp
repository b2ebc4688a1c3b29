// SPDX-License-Identifier: Apache-2.0
// Sums and medians of timed frames.
#include "frame_timing.h"

namespace terray::bench {
namespace {

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

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
