// SPDX-License-Identifier: Apache-2.0
// Units of heights: what files call them, and how many metres they are.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "terray/options.h"

namespace terray {

struct HeightUnitFacts {
    std::string name;  ///< "m", "ft", "us-ft", ...
    double metres = 1;
};

HeightUnitFacts describeHeightUnit(HeightUnit unit);
/// "m", "Metre", "feet", "US survey foot", "ftUS", ...; nothing for what is no known length.
std::optional<HeightUnitFacts> parseHeightUnit(std::string_view text);

}  // namespace terray
