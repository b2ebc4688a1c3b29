// SPDX-License-Identifier: Apache-2.0
// TERRAY_SIMD_CLONES: compiles a plain loop for several x86 levels; the machine picks on loading.
#pragma once

// Results are the same on every level: no fast-math, no contraction, std::fma is one rounding
// everywhere. Sanitizers cannot start with the indirect functions that this makes.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define TERRAY_SIMD_CLONES \
    __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define TERRAY_SIMD_CLONES
#endif
