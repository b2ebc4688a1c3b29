// SPDX-License-Identifier: Apache-2.0
// Reports a failed TERRAY_ASSERT and aborts.
#include "base/assert.h"

#include <cstdio>
#include <cstdlib>

namespace terray {

void assertFailed(const char* condition, const char* file, int line) {
    std::fprintf(stderr, "terray: bug at %s:%d: '%s' does not hold; please report it\n", file, line,
                 condition);
    std::abort();
}

}  // namespace terray
