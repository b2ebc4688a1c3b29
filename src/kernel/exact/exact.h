// SPDX-License-Identifier: Apache-2.0
// The tracer in double precision, one ray at a time: the judge of the few lanes that the float
// packets cannot decide. The same two-stage traversal (directory, then a tile's pyramid), no
// margins.
#pragma once

#include "kernel/layout/layout.h"

namespace terray::exact {

/// First hit; steps are counted into the hit. t in the Hit is rounded to float from double.
Hit firstHit(const TerrainCut& cut, const Ray& ray);

/// Shadow test by the rules of kernel/trace.h.
bool occluded(const TerrainCut& cut, const Hit& hit, const Ray& ray);

/// Interval of t for which the ray is inside the true rectangle, [tMin, tMax] and below the highest
/// or above the lowest thing drawn (by `slack` metres); empty if begin > end.
struct Clip {
    double begin, end;
};
Clip clipRay(const TerrainCut& cut, const Ray& ray);

}  // namespace terray::exact
