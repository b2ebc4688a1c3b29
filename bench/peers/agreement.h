// SPDX-License-Identifier: Apache-2.0
// How far the pictures of two contenders are apart.
#pragma once

#include <vector>

#include "peers/caster.h"

namespace terray::bench {

/// What a caster finds at every pixel of a picture, row by row; not timed.
std::vector<float> readPicture(const Caster& caster, int width, int height);

struct Agreement {
    double farShare = 0;   ///< of the pixels that both hit: distances more than 0.1 m apart
    double flipShare = 0;  ///< of all pixels: one hits, the other does not
    double worst = 0;      ///< largest difference of distances, metres
};
Agreement compareDistances(const std::vector<float>& a, const std::vector<float>& b);

/// Share of the marked pixels that differ: for pictures of 0 and 1.
double shareOfDifferent(const std::vector<float>& a, const std::vector<float>& b,
                        const std::vector<bool>& marked);

}  // namespace terray::bench
