// SPDX-License-Identifier: Apache-2.0
// One cell of the column march in SIMD lanes: the float rays and their errors, what a cell does to
// them, and the distance of a hit.

#if defined(TERRAY_MARCH_CELL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_MARCH_CELL_INL_H_
#undef TERRAY_MARCH_CELL_INL_H_
#else
#define TERRAY_MARCH_CELL_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"
#include "kernel/columns.h"
#include "kernel/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// Rays of one packet, relative to the tile's anchor; w counts from w0.
struct ColumnRays {
    VF x, y, z, dx, dy, dz, bend, inverseDx, inverseDy, length2, length, forward0, forward;
    VF wBegin;
};

HWY_INLINE VF inverseOf(VF step) {
    return hn::IfThenElse(hn::Abs(step) < setF(1e-30f), setF(1e30f), setF(1.0f) / step);
}

/// Rays without their inverses and lengths.
HWY_INLINE ColumnRays makeRays(const MarchGroup& group, int row, size_t p) {
    const size_t lane = p % kMarchGroupColumns;
    const auto term = [&](RayTerm k) {
        return loadF(group.columns[k] + lane) + setF(group.rows[row][k]);
    };
    ColumnRays r;
    r.dx = term(kTermDx);
    r.dy = term(kTermDy);
    r.dz = term(kTermDz);
    r.x = term(kTermX);
    r.y = term(kTermY);
    r.z = term(kTermZ);
    r.length2 = term(kTermLength2);
    r.forward0 = term(kTermForward0);
    r.forward = term(kTermForward);
    const VF w0 = setF(group.w0);
    r.wBegin = hn::Neg(w0);
    r.bend = hn::Zero(DF());
    if (group.bend == 0) return r;
    // |d_h|^2 = length^2 - rise^2: the bend of a ray that covers so much level ground per w
    const VF rise = r.dz * setF(group.exaggeration);
    const VF level = hn::Max(r.length2 - rise * rise, hn::Zero(DF()));
    r.bend = level * setF(group.bend);
    const VF turned = r.bend * w0;
    r.z = hn::MulAdd(turned, w0, r.z);
    r.dz = r.dz + (turned + turned);
    return r;
}

/// What a ray needs that goes from cell to cell.
HWY_INLINE void addInverses(const TerrainCut& cut, const MarchGroup& group, ColumnRays& r) {
    r.length = hn::Sqrt(r.length2);
    r.inverseDx = inverseOf(r.dx);
    r.inverseDy = inverseOf(r.dy);
    if (group.eyeOutside) {
        const VF left = setF(static_cast<float>(-group.anchorX)) - r.x;
        const VF top = setF(static_cast<float>(-group.anchorY)) - r.y;
        const VF ax = left * r.inverseDx, ay = top * r.inverseDy;
        const VF bx = hn::MulAdd(setF(static_cast<float>(cut.cellsX)), r.inverseDx, ax);
        const VF by = hn::MulAdd(setF(static_cast<float>(cut.cellsY)), r.inverseDy, ay);
        r.wBegin = hn::Max(r.wBegin, hn::Max(hn::Min(ax, bx), hn::Min(ay, by)));
    }
}

/// A lane's cell as its ray sees it.
struct MarchCell {
    VF wIn, wOut;
    VF u, v, du, dv;  ///< place at wIn, in the cell; change per w
    VF f0, f1, slope,
        f2;  ///< ray less surface at wIn and wOut; its derivative at wIn; its curvature
    VF low;  ///< least f in between, where it matters
    VF error;
    MI alongX;
    MI open;  ///< not to be told
    MI hole;  ///< the ray passes through a hole
};

/// Least f in the cell, where it matters: f is convex, so that it may be lowest inside.
HWY_INLINE VF lowestOf(const MarchCell& k, MI active) {
    const VF ends = hn::Min(k.f0, k.f1), length = k.wOut - k.wIn, zero = hn::Zero(DF());
    const VF twice = k.f2 + k.f2;
    const MF inside = hn::And(k.slope<zero, hn::MulAdd(twice, length, k.slope)> zero);
    const MF matters = hn::And(inside, k.f1 > hn::Neg(k.error));
    if (hn::AllFalse(DI(), hn::And(active, maskI(matters)))) return ends;
    const VF turn = hn::NegMulAdd(k.slope, k.slope / (twice + twice), k.f0);
    return hn::IfThenElse(matters, turn, ends);
}

/// The same for two triangles: the one that is entered, and the other beyond the diagonal from post
/// (1, 0) to post (0, 1). A hit in the second makes the cell begin at the diagonal.
HWY_INLINE void splitCell(const CellPosts& c, const ColumnRays& r, MarchCell& k) {
    const VF zero = hn::Zero(DF()), one = setF(1.0f), length = k.wOut - k.wIn;
    const VF b = c.h10 - c.h00, a = c.h01 - c.h00, b1 = c.h11 - c.h01, a1 = c.h11 - c.h10;
    const VF before = one - k.u - k.v;
    const MF lower = hn::Or(before > zero, hn::And(before == zero, k.du + k.dv < zero));
    // A ray that begins within the cell begins over a triangle, not over the bilinear surface.
    const VF twist = b1 - b;
    k.f0 = k.f0 + twist * hn::IfThenElse(before > zero, k.u * k.v, (one - k.u) * (one - k.v));
    const VF s = before / (k.du + k.dv);
    const MF crosses = hn::And(s > zero, s < length);
    const VF climbLower = hn::MulAdd(b, k.du, a * k.dv),
             climbUpper = hn::MulAdd(b1, k.du, a1 * k.dv);
    const VF first = hn::IfThenElse(lower, climbLower, climbUpper);
    const VF second = hn::IfThenElse(lower, climbUpper, climbLower);
    k.slope = hn::MulAdd(r.bend + r.bend, k.wIn, r.dz) - first;
    k.f2 = r.bend;
    const VF middle = hn::MulAdd(s, hn::MulAdd(r.bend, s, k.slope), k.f0);
    const VF sag = setF(0.25f) * r.bend * length * length;
    const VF met = hn::Min(hn::IfThenElse(crosses, hn::Min(k.f1, middle), k.f1), k.f0);
    k.low = met - sag;  // enough to pass, but no hit if it is not met
    const MF unmet = hn::And(k.low < hn::Neg(k.error), met >= hn::Neg(k.error));
    const MF onDiagonal = hn::And(crosses, hn::Abs(middle) <= k.error);
    // f0 may be the diagonal's from here on: a ray that came in from below must not pass for one
    // from above.
    const MF notAbove = k.f0 <= k.error;
    k.open = hn::Or(k.open, maskI(hn::Or(notAbove, hn::Or(unmet, onDiagonal))));
    const MF beyond = hn::And(crosses, middle > zero);
    k.f0 = hn::IfThenElse(beyond, middle, k.f0);
    k.slope =
        hn::IfThenElse(beyond, hn::MulAdd(r.bend + r.bend, s, k.slope + first - second), k.slope);
    k.u = hn::IfThenElse(beyond, hn::MulAdd(k.du, s, k.u), k.u);
    k.v = hn::IfThenElse(beyond, hn::MulAdd(k.dv, s, k.v), k.v);
    k.wIn = hn::IfThenElse(beyond, k.wIn + s, k.wIn);
}

/// A place so near a corner of its cell that the ray may really be in a cell beyond.
HWY_INLINE MF isAtCorner(VF u, VF v, VF shift) {
    const VF one = setF(1.0f);
    const VF sideU = hn::Min(hn::Abs(u), hn::Abs(one - u));
    const VF sideV = hn::Min(hn::Abs(v), hn::Abs(one - v));
    return hn::Max(sideU, sideV) < setF(8.0f) * shift;
}

/// What the error of f in a cell depends on.
struct MarchReach {
    VF w;       ///< largest |w|
    VF shift;   ///< error of places, cells
    MF corner;  ///< the ray leaves at a corner
    VF grade;   ///< of the cell, metres a cell
    VF relief;  ///< largest height, from the anchor's
};
HWY_INLINE VF errorIn(const MarchReach& k, const MarchErrors& e, float maxDelta) {
    // A ray that leaves near a corner may really pass through the next cell but one: there the
    // surface differs by no more than the steepest ground does over the lattice error.
    const VF steepest = hn::IfThenElseZero(k.corner, setF(4.0f * maxDelta));
    const VF rounding = hn::MulAdd(setF(kFloatError), k.relief + k.grade, setF(e.height0));
    return hn::MulAdd(hn::MulAdd(setF(2.0f), k.grade, steepest), k.shift,
                      hn::MulAdd(setF(e.height1), k.w, rounding));
}

template <bool kInt16, bool kTriangles>
HWY_INLINE MarchCell lookAt(const TerrainCut& cut, const Pools& pools, const MarchGroup& group,
                            const ColumnRays& r, const MarchErrors& e, const MarchLanes& m,
                            size_t p, VI x, VI y, VI mip, MI lanes) {
    const VI cellMask = setI(kSlotCells - 1);
    const VI cx = hn::And(shiftRight(x, mip), cellMask), cy = hn::And(shiftRight(y, mip), cellMask);
    const CellPosts c = loadPosts<kInt16, true>(pools,
                                                {loadI(m.postsOffset + p), loadI(m.postsCode + p),
                                                 loadF(m.postsZ + p), loadF(m.postsStep + p)},
                                                cx, cy, lanes);
    MarchCell k;
    const VI ax = setI(group.anchorX);
    const VI ay = setI(group.anchorY);
    const VF inverse = hn::BitCast(DF(), hn::ShiftLeft<23>(setI(127) - mip));
    const VF size = hn::BitCast(DF(), hn::ShiftLeft<23>(setI(127) + mip));
    const VF left = hn::ConvertTo(DF(), shiftLeft(shiftRight(x, mip), mip) - ax) - r.x;
    const VF top = hn::ConvertTo(DF(), shiftLeft(shiftRight(y, mip), mip) - ay) - r.y;
    const VF wx0 = left * r.inverseDx, wx1 = hn::MulAdd(size, r.inverseDx, wx0);
    const VF wy0 = top * r.inverseDy, wy1 = hn::MulAdd(size, r.inverseDy, wy0);
    const VF outX = hn::Max(wx0, wx1), outY = hn::Max(wy0, wy1);
    k.alongX = maskI(outX <= outY);
    k.wIn = hn::Max(hn::Max(hn::Min(wx0, wx1), hn::Min(wy0, wy1)), r.wBegin);
    k.wOut = hn::Max(hn::Min(outX, outY), k.wIn);
    k.du = r.dx * inverse;
    k.dv = r.dy * inverse;
    k.u = hn::MulSub(r.dx, k.wIn, left) * inverse;
    k.v = hn::MulSub(r.dy, k.wIn, top) * inverse;
    const VF length = k.wOut - k.wIn;
    const VF u1 = hn::MulAdd(k.du, length, k.u), v1 = hn::MulAdd(k.dv, length, k.v);

    const VF b = c.h10 - c.h00, a = c.h01 - c.h00, d = (c.h11 - c.h01) - b;
    const auto surface = [&](VF u, VF v) {
        return hn::MulAdd(v, hn::MulAdd(d, u, a), hn::MulAdd(b, u, c.h00));
    };
    const auto height = [&](VF w) { return hn::MulAdd(w, hn::MulAdd(r.bend, w, r.dz), r.z); };
    const VF ground0 = surface(k.u, k.v), ground1 = surface(u1, v1);
    k.f0 = height(k.wIn) - ground0;
    k.f1 = height(k.wOut) - ground1;
    const VF climb =
        hn::MulAdd(b, k.du, hn::MulAdd(a, k.dv, d * hn::MulAdd(k.u, k.dv, k.v * k.du)));
    k.slope = hn::MulAdd(r.bend + r.bend, k.wIn, r.dz) - climb;
    k.f2 = hn::NegMulAdd(d * k.du, k.dv, r.bend);

    const VF farthest = hn::Max(hn::Abs(k.wIn), hn::Abs(k.wOut));
    const VF shift = hn::MulAdd(setF(e.shift1), farthest, setF(e.shift0)) * inverse;
    const MF corner = isAtCorner(u1, v1, shift);
    k.open = k.hole = noLanes();
    if (cut.hasHoles != 0) {  // a ray that touches a corner of one may meet the next cell's there
        k.open = hn::And(c.hole, maskI(hn::Or(corner, isAtCorner(k.u, k.v, shift))));
        k.hole = hn::AndNot(k.open, c.hole);
    }
    k.error = errorIn({farthest, shift, corner, hn::Abs(b) + hn::Abs(a) + hn::Abs(d) + hn::Abs(d),
                       hn::Max(hn::Abs(ground0), hn::Abs(ground1))},
                      e, cut.maxDelta);
    if constexpr (kTriangles)
        splitCell(c, r, k);
    else
        k.low = lowestOf(k, lanes);
    return k;
}

/// Where lanes go that pass through their cell.
struct MarchStep {
    VI x, y;
    MI outside;
};
HWY_INLINE MarchStep nextCell(const TerrainCut& cut, const MarchGroup& group, const ColumnRays& r,
                              const MarchCell& k, VI x, VI y, VI mip) {
    const VI one = setI(1), zero = hn::Zero(DI());
    const VI size = shiftLeft(one, mip), last = size - one;
    const VI x0 = hn::AndNot(last, x), y0 = hn::AndNot(last, y);
    const VI acrossX = select(maskI(r.dx >= hn::Zero(DF())), x0 + size, x0 - one);
    const VI acrossY = select(maskI(r.dy >= hn::Zero(DF())), y0 + size, y0 - one);
    const VI ax = setI(group.anchorX);
    const VI ay = setI(group.anchorY);
    MarchStep s;
    s.x = select(k.alongX, acrossX, cellAt(r.x, r.dx, k.wOut, ax, x0, last));
    s.y = select(k.alongX, cellAt(r.y, r.dy, k.wOut, ay, y0, last), acrossY);
    s.outside = hn::Or(hn::Or(s.x < zero, s.y < zero),
                       hn::Or(s.x > setI(cut.cellsX - 1), s.y > setI(cut.cellsY - 1)));
    return s;
}

/// Where f0 + slope s + f2 s^2 goes through zero from above, and |f'| there.
struct MarchRoot {
    VF s, rate, disc;
};
HWY_INLINE MarchRoot rootOf(VF f0, VF slope, VF f2) {
    const VF zero = hn::Zero(DF());
    MarchRoot r;
    r.disc = hn::Max(hn::NegMulAdd(setF(4.0f) * f2, f0, slope * slope), zero);
    r.rate = hn::Sqrt(r.disc);
    const MF falling = slope <= zero;
    const VF numerator = hn::IfThenElse(falling, f0 + f0, hn::Neg(slope + r.rate));
    const VF denominator = hn::IfThenElse(falling, r.rate - slope, f2 + f2);
    r.s = numerator / denominator;
    return r;
}

/// Lanes whose hit at distance t float arithmetic tells well enough. The tolerance of
/// docs/surface.md: |dt| <= max(1 mm, 1e-5 t, 2 eps / |f'|). Half of it.
HWY_INLINE MF isPlaced(const MarchRoot& root, VF slope, const ColumnRays& r, VF t, VF error,
                       float rounding) {
    const VF allowed = hn::Max(setF(5e-4f), t * setF(5e-6f));
    const MF near = hn::Or(error * r.length <= allowed * root.rate, error <= setF(2.0f * rounding));
    return hn::And(near, root.disc > setF(1e-3f) * (slope * slope));
}

/// Fixes the hits of a packet: where f goes through zero from above. Returns the lanes for which
/// float arithmetic tells the distance well enough.
HWY_INLINE MI fixHits(const MarchGroup& group, const ColumnRays& r, const MarchCell& k,
                      MarchLanes& m, size_t p, MI hits, float rounding) {
    const VF zero = hn::Zero(DF()), one = setF(1.0f);
    const MarchRoot root = rootOf(k.f0, k.slope, k.f2);
    const VF s = hn::Min(hn::Max(root.s, zero), k.wOut - k.wIn);
    const VF w = k.wIn + (s + setF(group.w0));
    const VF t = w * r.length;
    storeF(hits, t, m.t + p);
    storeF(hits, hn::Min(hn::Max(hn::MulAdd(k.du, s, k.u), zero), one), m.u + p);
    storeF(hits, hn::Min(hn::Max(hn::MulAdd(k.dv, s, k.v), zero), one), m.v + p);
    storeF(hits, hn::MulAdd(w, r.forward, r.forward0), m.forward + p);
    return hn::And(hits, maskI(isPlaced(root, k.slope, r, t, k.error, rounding)));
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
