// SPDX-License-Identifier: Apache-2.0
// An image tile by column marching: each row begins where the row below has hit, as far as the
// ground between the two is not too steep for that.
#pragma once

#include <span>

#include "kernel/beam.h"
#include "kernel/trace.h"
#include "view/ray_frame.h"

namespace terray {

/// Pixels a side of a beam, and of the blocks of 64 rays that are traced together.
constexpr int kBeamSide = 16, kBlockSide = 8;

/// Casts the rays of at most kMarchColumns columns and rows. hits: row by row, `stride` apart.
void marchTile(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
               std::span<Hit> hits, size_t stride, TraceCounters& counters);

/// The same without sharing between rows, ray by ray from where bundles of 16 x 16 rays end.
void castByBeams(const TerrainCut& cut, const RayFrame& rays, const ImageTile& tile, Vec2 offset,
                 std::span<Hit> hits, size_t stride, TraceCounters& counters);

/// The bundle of all rays of a pixel rectangle, and how its parameter scales.
Beam beamOf(const RayFrame& rays, double x, double y, double width, double height);

}  // namespace terray
