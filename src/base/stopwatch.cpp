// SPDX-License-Identifier: Apache-2.0
// Memory figures from the operating system.
#include "base/stopwatch.h"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

namespace terray {

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
