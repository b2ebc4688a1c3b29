// SPDX-License-Identifier: Apache-2.0
// What C++ needs to read the shader text: the few names of GLSL that it uses.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace terray::glsl {

using uint = uint32_t;  // NOLINT(readability-identifier-naming): the name in GLSL

inline int min(int a, int b) { return a < b ? a : b; }
inline int max(int a, int b) { return a > b ? a : b; }
inline uint max(uint a, uint b) { return a > b ? a : b; }
inline float min(float a, float b) { return a < b ? a : b; }
inline float max(float a, float b) { return a > b ? a : b; }
inline int clamp(int x, int low, int high) { return min(max(x, low), high); }
inline float clamp(float x, float low, float high) { return min(max(x, low), high); }
inline float abs(float x) { return std::fabs(x); }
inline float floor(float x) { return std::floor(x); }
inline float sqrt(float x) { return std::sqrt(x); }
inline float uintBitsToFloat(uint bits) { return std::bit_cast<float>(bits); }
inline float intBitsToFloat(int bits) { return std::bit_cast<float>(bits); }

#include "kernel/glsl/layout.glsl"

}  // namespace terray::glsl
