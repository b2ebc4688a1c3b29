// SPDX-License-Identifier: Apache-2.0
// Sky light: the share of the sky seen from each post of a grid, by line sweeps over fixed
// azimuths.
#pragma once

#include <cstdint>
#include <span>

namespace terray {

/// A grid of heights, row-major, NaN for holes; steps in metres along rows and columns.
struct SkyGrid {
    const float* heights = nullptr;
    int width = 0, height = 0;
    double stepX = 1, stepY = 1;
};

/// visible[k] in 0..1: cosine-weighted share of the upper hemisphere that is open sky for a level
/// receiver, over `azimuths` (>= 4) directions. No noise: the same directions everywhere. All
/// cores.
void computeSkyVisibility(const SkyGrid& grid, int azimuths, std::span<float> visible);

}  // namespace terray
