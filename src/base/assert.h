// SPDX-License-Identifier: Apache-2.0
// TERRAY_ASSERT: for bugs only, never for bad input. On in debug builds and with TERRAY_ASSERTS.
#pragma once

namespace terray {
[[noreturn]] void assertFailed(const char* condition, const char* file, int line);
}

#if !defined(NDEBUG) || defined(TERRAY_ASSERTS)
#define TERRAY_ASSERT(condition) \
    ((condition) ? static_cast<void>(0) : ::terray::assertFailed(#condition, __FILE__, __LINE__))
#else
#define TERRAY_ASSERT(condition) static_cast<void>(0)
#endif
