// SPDX-License-Identifier: Apache-2.0
// What rays see that miss the terrain: sky, one colour, or nothing.
#pragma once

#include <string>

#include "base/result.h"
#include "shade/rules/air.h"
#include "shade/shade.h"

namespace terray {

struct Background {
    enum class Kind { Sky, Colour, Transparent } kind = Kind::Sky;
    rules::Rgb colour{0.0f};  ///< scene-linear
};
/// "sky", "transparent" or "#rrggbb". Error Usage.
Result<Background> parseBackground(const std::string& text);

}  // namespace terray
