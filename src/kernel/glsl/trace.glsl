// SPDX-License-Identifier: Apache-2.0
// The maximum-mipmap traversal as shader text, one ray a call (docs/traversal.md). Every comparison
// carries the float ray's error, as in kernel/simd/trace_block-inl.h: a ray ends as a certain miss, a
// certain hit, or open. README.md says what the includer supplies.

#define real float
#define LEAF_FN
#include "kernel/leaf/leaf.h.inl"
#undef LEAF_FN
#undef real

#include "kernel/glsl/walk.glsl"
#include "kernel/glsl/cell.glsl"

TraceHit traceRay(TraceCut cut, TraceRay ray, RaySlack slack) {
    Walk w = beginWalk(cut, ray, slack);
    while (w.result == kWalkGoesOn) {
        // All rays that run together come to a tile, then to a cell, before any of them tests one.
        while (w.result == kWalkGoesOn && w.mip < 0) w = stepSquare(cut, ray, w);
        while (w.result == kWalkGoesOn && w.mip >= 0 && w.level > w.mip) w = stepBlock(cut, ray, w);
        if (w.result == kWalkGoesOn && w.mip >= 0) w = stepCell(cut, ray, w);
    }
    uint flags = w.under ? kHitUnderSheet : 0u;
    if (w.result == kWalkHits) flags |= w.hitFlags;
    if (w.result == kWalkUnsure) flags |= kHitUncertain;
    int mip = max(w.mip, 0);
    int column = (w.x >> mip) & (kSlotCells - 1);
    int row = (w.y >> mip) & (kSlotCells - 1);
    TraceHit hit;
    hit.t = w.t;
    hit.tile = w.slot;
    hit.cell = uint(row * kSlotCells + column);
    hit.u = w.u;
    hit.v = w.v;
    hit.stepsMipFlags = uint(min(w.steps, 0xFFFF)) | (uint(mip) << 16) | (flags << 24);
    return hit;
}
