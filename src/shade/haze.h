// SPDX-License-Identifier: Apache-2.0
// The frame's air: sky colours, where the gradient starts, and haze that scales with the scene.
#pragma once

#include "shade/rules/air.h"
#include "shade/shade.h"

namespace terray {

/// Distances from the eye to the terrain's box, in picture space.
struct SceneReach {
    float nearest = 0, farthest = 1;
    float farSine = 0;  ///< sine of the elevation under which the farthest edge is seen
};
SceneReach computeReach(const Camera& camera, const TerrainInfo& info, double exaggeration);

/// Without --haze the far edge keeps a third of its contrast.
rules::Air makeAir(const SceneReach& reach, const Camera& camera, const ShadeSettings& settings);

}  // namespace terray
