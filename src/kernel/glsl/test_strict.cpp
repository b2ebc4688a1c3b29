// SPDX-License-Identifier: Apache-2.0
// The shader text as C++, every operation rounded as written.
#include <bit>

#include "kernel/glsl/cpp.h"
#include "kernel/glsl/test_program.h"

#define SHADER_SPACE glsl
#define SHADER_TRACE shaderTraceStrict
#include "kernel/glsl/test_program.h.inl"
