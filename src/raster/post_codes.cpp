// SPDX-License-Identifier: Apache-2.0
// The choice of 16-bit codes for integer rasters.
#include "raster/post_codes.h"

#include <algorithm>

namespace terray {
namespace {

constexpr int kMaxShift = 12;  // finer fractions than 1/4096 of a source step serve nobody

/// Whether every raw value decodes to its height within one float ulp, and as std::fma does it.
bool decodesWell(const PostCodes& codes, const SampleRules& rules, int64_t rawMin, int64_t rawMax) {
    const double largest = std::max(std::abs(rules.metres(static_cast<double>(rawMin))),
                                    std::abs(rules.metres(static_cast<double>(rawMax))));
    const auto top = static_cast<float>(largest);
    const double ulp =
        static_cast<double>(std::nextafter(top, HUGE_VALF)) - static_cast<double>(top);
    for (int64_t raw = rawMin; raw <= rawMax; ++raw) {
        const int64_t code = (raw - codes.base) << codes.shift;
        const float height = codes.decode(code);
        const float fused = std::fma(codes.zStep, static_cast<float>(code), codes.z0);
        const double error = static_cast<double>(height) - rules.metres(static_cast<double>(raw));
        if (height != fused || std::abs(error) > ulp) return false;
    }
    return true;
}

}  // namespace

std::optional<PostCodes> choosePostCodes(const SampleRules& rules, double rawMin, double rawMax) {
    const double steps = rawMax - rawMin;
    if (!rules.integer || !(steps >= 0) || steps > static_cast<double>(PostCodes::kMaxCode) ||
        std::max(std::abs(rawMin), std::abs(rawMax)) > 0x1p52) {
        return std::nullopt;
    }
    const auto first = static_cast<int64_t>(rawMin), last = static_cast<int64_t>(rawMax);
    PostCodes codes;
    while (codes.shift < kMaxShift && (last - first) << (codes.shift + 1) <= PostCodes::kMaxCode) {
        ++codes.shift;
    }
    // spare codes go to both ends: fitted posts of coarser mips may overshoot a little
    const int64_t spare = (PostCodes::kMaxCode >> codes.shift) - (last - first);
    codes.base = first - spare / 2;
    const double zBase = rules.metres(static_cast<double>(codes.base));
    const double zStep = std::ldexp(rules.scale * rules.metresPerUnit, -codes.shift);
    codes.z0 = static_cast<float>(zBase);
    codes.zStep = static_cast<float>(zStep);
    if (!std::isnormal(codes.zStep) || codes.zStep < 0 || !decodesWell(codes, rules, first, last)) {
        return std::nullopt;
    }
    return codes;
}

}  // namespace terray
