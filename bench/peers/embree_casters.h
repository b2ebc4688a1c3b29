// SPDX-License-Identifier: Apache-2.0
// Embree's calls as contenders: single rays, packets of 8 and 16 with the coherent flag, shadows.
#pragma once

#include "peers/caster.h"
#include "peers/embree_scene.h"

namespace terray::bench {

/// rtcIntersect1, 8 or 16 (`lanes`), for perspective cameras.
std::unique_ptr<Caster> makeEmbreeCaster(const EmbreeScene& scene, const RayFrame& frame,
                                         int lanes);
/// rtcOccluded16 from the places at the distances of a picture's pixels, row by row, to the sun.
std::unique_ptr<Caster> makeEmbreeShadowCaster(const EmbreeScene& scene, const RayFrame& frame,
                                               std::vector<float> distances);

}  // namespace terray::bench
