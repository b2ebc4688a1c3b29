// SPDX-License-Identifier: Apache-2.0
// The shader text as C++, every operation rounded as written.
#define SHADER_TRACE shaderTraceStrict
#include "kernel/glsl/test_program.h.inl"
