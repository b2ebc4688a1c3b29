// SPDX-License-Identifier: Apache-2.0
// Where in a pixel its rays go through: the same places in every pixel, picture and run.
#pragma once

#include <array>
#include <span>

#include "math/types.h"

namespace terray {

/// Sub-pixel places in 0..1 for 1, 2, 4, 8 or 16 rays a pixel: rotated grids that put every ray on
/// its own row and column (the standard multisample patterns of Direct3D 11, in sixteenths).
inline std::span<const Vec2> samplePattern(int samples) {
    constexpr auto at = [](int x, int y) {
        return Vec2{0.5 + static_cast<double>(x) / 16, 0.5 + static_cast<double>(y) / 16};
    };
    static const std::array<Vec2, 1> kOne{at(0, 0)};
    static const std::array<Vec2, 2> kTwo{at(4, 4), at(-4, -4)};
    static const std::array<Vec2, 4> kFour{at(-2, -6), at(6, -2), at(-6, 2), at(2, 6)};
    static const std::array<Vec2, 8> kEight{at(1, -3), at(-1, 3),  at(5, 1), at(-3, -5),
                                            at(-5, 5), at(-7, -1), at(3, 7), at(7, -7)};
    static const std::array<Vec2, 16> kSixteen{
        at(1, 1),  at(-1, -3), at(-3, 2),  at(4, -1), at(-5, -2), at(2, 5),  at(5, 3), at(3, -5),
        at(-2, 6), at(0, -7),  at(-4, -6), at(-6, 4), at(-8, 0),  at(7, -4), at(6, 7), at(-7, -8)};
    switch (samples) {
        case 2: return kTwo;
        case 4: return kFour;
        case 8: return kEight;
        case 16: return kSixteen;
        default: return kOne;
    }
}

}  // namespace terray
