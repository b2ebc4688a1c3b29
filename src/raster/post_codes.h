// SPDX-License-Identifier: Apache-2.0
// 16-bit posts of integer rasters: which code stands for which raw value, without loss.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

#include "raster/raster_header.h"
#include "tile/terrain_info.h"

namespace terray {

/// code = (raw - base) << shift, height = z0 + zStep * code (one rounding). The shift leaves codes
/// between the raw values for the fractions of coarser mips.
struct PostCodes {
    int64_t base = 0;  ///< raw value of code 0
    int shift = 0;
    float z0 = 0, zStep = 1;

    static constexpr int64_t kMaxCode = kHolePost - 1;
    /// Height of a code; the same float as std::fma(zStep, code, z0), which kernels use.
    float decode(int64_t code) const {
        return static_cast<float>(static_cast<double>(zStep) * static_cast<double>(code) +
                                  static_cast<double>(z0));
    }
};

/// The codes for integer raw values rawMin..rawMax: as fine as 16 bits allow. None if the range
/// does not fit, or if float z0 and zStep cannot reproduce the heights to within one float ulp of
/// the highest (they are exact if the step is a sum of few powers of two, as 1 or 0.25 is).
std::optional<PostCodes> choosePostCodes(const SampleRules& rules, double rawMin, double rawMax);

}  // namespace terray
