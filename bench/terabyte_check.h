// SPDX-License-Identifier: Apache-2.0
// The terabyte's bounds held against its posts, and how rough it is.
#pragma once

#include <random>
#include <string>

#include "terabyte_source.h"

namespace terray::bench {

/// What is wrong with the bounds of a random block of a random tile; empty: nothing.
std::string faultOfBlock(const TerabyteSource& source, TileReader& reader, std::mt19937& random);

/// Root of the mean square of the difference between mips 0 and 1, over random tiles, metres.
double finestRms(const TerabyteSource& source, int tiles, std::mt19937& random);

}  // namespace terray::bench
