// SPDX-License-Identifier: Apache-2.0
// What makes a ray of a picture, as a sum of a part of its column and a part of its row.
#pragma once

#include <array>

namespace terray {

/// w is the parameter that all rays of a picture share (RayFrame::PencilRay).
enum RayTerm {
    kTermX,  ///< place at w = 0, lattice
    kTermY,
    kTermZ,   ///< true metres
    kTermDx,  ///< change of place per w
    kTermDy,
    kTermDz,
    kTermLength2,   ///< square of metres in picture space per w
    kTermForward0,  ///< metres ahead at w = 0, horizontally: see MarchLanes::forward
    kTermForward,   ///< metres ahead per w
    kTermCount
};
using RayTerms = std::array<double, kTermCount>;

}  // namespace terray
