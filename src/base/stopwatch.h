// SPDX-License-Identifier: Apache-2.0
// Wall-clock timing of stages, and the process's peak memory.
#pragma once

#include <chrono>
#include <cstdint>

namespace terray {

class Stopwatch {
public:
    double elapsedMs() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
            .count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// CPU time of this thread: work done, whatever else the machine does. confined to the thread that
/// made it.
class CpuStopwatch {
public:
    double elapsedMs() const { return threadCpuMs() - start_; }

private:
    static double threadCpuMs();
    double start_ = threadCpuMs();
};

/// Largest resident set of this process so far, in bytes.
uint64_t peakResidentBytes();
/// Physical memory of the machine, in bytes.
uint64_t physicalMemoryBytes();

/// Hands freed heap memory back to the system: after a stage whose buffers the next one does not
/// need.
void releaseFreedMemory();

}  // namespace terray
