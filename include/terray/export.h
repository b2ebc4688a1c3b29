// SPDX-License-Identifier: Apache-2.0
// TERRAY_API: marks what libterray exports; everything else in it is hidden.
#pragma once

#if defined(__GNUC__)
#define TERRAY_API __attribute__((visibility("default")))
#else
#define TERRAY_API
#endif
