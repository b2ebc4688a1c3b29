// SPDX-License-Identifier: Apache-2.0
// The shader text as C++ with contracted multiply-adds: compiled for machines that have them.
#include <bit>

#include "kernel/glsl/cpp.h"
#include "kernel/glsl/test_program.h"

#define SHADER_SPACE glsl
#define SHADER_TRACE shaderTraceContracted
#include "kernel/glsl/test_program.h.inl"
