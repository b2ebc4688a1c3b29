// SPDX-License-Identifier: Apache-2.0
// How much a random test does: sanitized code is ten times slower, and shows what it shows with
// fewer rays.
#pragma once

namespace terray::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kLess = 4;
#else
constexpr int kLess = 1;
#endif

}  // namespace terray::test
