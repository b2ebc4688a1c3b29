// SPDX-License-Identifier: Apache-2.0
// Terray's own tracers as contenders.
#pragma once

#include "peers/caster.h"
#include "technique/technique.h"

namespace terray::bench {

/// A technique as `terray render` uses it.
std::unique_ptr<Caster> makeTechniqueCaster(const Technique& technique, const TerrainCut& cut,
                                            const RayFrame& frame);
/// The kernel's packets alone: nothing shared between neighbouring rays.
std::unique_ptr<Caster> makePacketCaster(const TerrainCut& cut, const RayFrame& frame);
/// The oracle in scalar double precision, on every 8th pixel of every 8th row.
std::unique_ptr<Caster> makeOracleCaster(const TerrainCut& cut, const RayFrame& frame);
/// Shadow rays from the hits of a picture, row by row, to the sun.
std::unique_ptr<Caster> makeShadowCaster(const TerrainCut& cut, const RayFrame& frame,
                                         std::vector<Hit> hits);

/// Hits of a whole picture, row by row; not timed.
std::vector<Hit> castHits(const Technique& technique, const TerrainCut& cut, const RayFrame& frame);

}  // namespace terray::bench
