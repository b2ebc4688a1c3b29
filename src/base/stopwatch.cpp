// SPDX-License-Identifier: Apache-2.0
// CPU time and memory figures from the operating system.
#include "base/stopwatch.h"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <ctime>

namespace terray {

double CpuStopwatch::threadCpuMs() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

uint64_t peakResidentBytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024u;
}

uint64_t physicalMemoryBytes() {
    return static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) *
           static_cast<uint64_t>(sysconf(_SC_PAGE_SIZE));
}

void releaseFreedMemory() { malloc_trim(0); }

}  // namespace terray
