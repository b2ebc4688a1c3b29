// SPDX-License-Identifier: Apache-2.0
// How much ground a pixel covers: ray differentials on the tangent plane.
#pragma once

#include <algorithm>
#include <cmath>

namespace terray::rules {

/// Width of the ground that a sample covers, in mip-0 cells: `area` square metres across a ray of
/// direction (dx, dy, dz), seen against the plane of slopes (planeX, planeY), not wider than a few
/// pixels where the look is grazing.
inline float footprint(float area, float dx, float dy, float dz, float planeX, float planeY,
                       float share, float perCellArea) {
    const float down = std::abs(dz - planeX * dx - planeY * dy);
    const float least = 0.15f * (1.0f + std::max(std::abs(planeX), std::abs(planeY)));
    return share * std::sqrt(area / std::max(down, least) * perCellArea);
}

/// `facing` = N.D kept from 0: a flatter look covers no more ground than this one.
inline float keptFacing(float facing) {
    constexpr float kGrazing = 0.06f;
    const float least = facing < 0 ? -kGrazing : kGrazing;
    return std::abs(facing) < kGrazing ? least : facing;
}

}  // namespace terray::rules
