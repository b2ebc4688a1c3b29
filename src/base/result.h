// SPDX-License-Identifier: Apache-2.0
// Helpers to make and pass on errors; Result itself is public (terray/result.h).
#pragma once

#include <fmt/format.h>

#include "terray/result.h"

namespace terray {

/// makeError(ErrorCode::Input, "'{}' is not a raster; ...", path)
template <class... Args>
Error makeError(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
    return Error{code, fmt::format(format, std::forward<Args>(args)...)};
}

}  // namespace terray

/// Returns the error of a Result expression from the calling function, if there is one.
#define TERRAY_TRY(expression)                                                        \
    do {                                                                              \
        if (auto tryResult = (expression); !tryResult.ok()) return tryResult.error(); \
    } while (false)
