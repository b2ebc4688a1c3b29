// SPDX-License-Identifier: Apache-2.0
// The short way of the column march: hits inside the very cell in which a ray begins, told without
// the cell's borders (docs/traversal.md, "Columns").

#if defined(TERRAY_MARCH_FIRST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_MARCH_FIRST_INL_H_
#undef TERRAY_MARCH_FIRST_INL_H_
#else
#define TERRAY_MARCH_FIRST_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"
#include "kernel/columns.h"
#include "kernel/simd/march_cell-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// f = ray less surface along a ray that begins above its cell's surface at w, s counting from
/// there: f0 + slope s + f2 s^2.
struct FirstWay {
    VF u, v, du, dv;  ///< place at s = 0, change per w
    VF f0, slope, f2;
    MF lanes;  ///< of which this is true up to the root
};

/// Places inside the unit square by more than `rim`.
HWY_INLINE MF isInside(VF u, VF v, VF rim) {
    const VF one = setF(1.0f);
    return hn::Min(hn::Min(u, one - u), hn::Min(v, one - v)) > rim;
}

/// Makes f that over the triangle which is hit; `second`: not the one in which the ray begins.
HWY_INLINE void chooseTriangle(const CellPosts& c, const ColumnRays& r, VF w, VF error, VF rim,
                               FirstWay& k, MF& second) {
    const VF zero = hn::Zero(DF()), one = setF(1.0f);
    const VF before = one - k.u - k.v;
    const MF lower = before > zero;
    const VF b = c.h10 - c.h00, a = c.h01 - c.h00, b1 = c.h11 - c.h01, a1 = c.h11 - c.h10;
    const VF height = hn::MulAdd(w, hn::MulAdd(r.bend, w, r.dz), r.z);
    const VF groundLower = hn::MulAdd(b, k.u, hn::MulAdd(a, k.v, c.h00));
    const VF groundUpper = hn::NegMulAdd(b1, one - k.u, hn::NegMulAdd(a1, one - k.v, c.h11));
    const VF rise = hn::MulAdd(r.bend + r.bend, w, r.dz);
    const VF slopeLower = rise - hn::MulAdd(b, k.du, a * k.dv);
    const VF slopeUpper = rise - hn::MulAdd(b1, k.du, a1 * k.dv);
    const VF f0 = height - hn::IfThenElse(lower, groundLower, groundUpper);
    const VF slope = hn::IfThenElse(lower, slopeLower, slopeUpper);
    const VF s = before / (k.du + k.dv);
    const VF middle = hn::MulAdd(s, hn::MulAdd(r.bend, s, slope), f0);
    // Above both ends of the first triangle by more than a chord's sag, so above all of it.
    second = hn::And(s > zero, middle - r.bend * s * s > error);
    k.lanes = hn::And(f0 - hn::IfThenElseZero(second, r.bend * s * s) > error,
                      hn::Abs(before) > rim + rim);
    k.f0 = hn::IfThenElse(second, height - hn::IfThenElse(lower, groundUpper, groundLower), f0);
    k.slope = hn::IfThenElse(second, hn::IfThenElse(lower, slopeUpper, slopeLower), slope);
    k.f2 = r.bend;
}

/// Cells of lanes that stand in the tile they were in; `lanes` are those.
struct FirstCells {
    VI x, y, cx, cy, mip;
    VF u, v, inverse;
    MI lanes;
};
HWY_INLINE FirstCells firstCells(const TerrainCut& cut, const MarchTile& tile, const ColumnRays& r,
                                 VF w, const MarchLanes& m, size_t p) {
    const VI ax = setI(static_cast<int32_t>(tile.anchorX));
    const VI ay = setI(static_cast<int32_t>(tile.anchorY));
    const VF px = hn::MulAdd(r.dx, w, r.x), py = hn::MulAdd(r.dy, w, r.y);
    FirstCells k;
    k.x = hn::ConvertTo(DI(), hn::Floor(px)) + ax;
    k.y = hn::ConvertTo(DI(), hn::Floor(py)) + ay;
    k.mip = loadI(m.mip + p);
    const VI zero = hn::Zero(DI()), cellMask = setI(kSlotCells - 1);
    const VI away =
        shiftRight(hn::Or(hn::Xor(k.x, loadI(m.tileX + p)), hn::Xor(k.y, loadI(m.tileY + p))),
                   k.mip + setI(kTileLevels));
    const MI outside = hn::Or(hn::Or(k.x, k.y) < zero,
                              hn::Or(k.x > setI(cut.cellsX - 1), k.y > setI(cut.cellsY - 1)));
    k.lanes = hn::AndNot(outside, hn::Eq(away, zero));
    const VI column = shiftRight(k.x, k.mip), line = shiftRight(k.y, k.mip);
    k.cx = hn::And(column, cellMask);
    k.cy = hn::And(line, cellMask);
    k.inverse = hn::BitCast(DF(), hn::ShiftLeft<23>(setI(127) - k.mip));
    k.u = (px - hn::ConvertTo(DF(), shiftLeft(column, k.mip) - ax)) * k.inverse;
    k.v = (py - hn::ConvertTo(DF(), shiftLeft(line, k.mip) - ay)) * k.inverse;
    return k;
}

/// Finds hits in the cells in which all lanes of a packet begin, `begin` metres ahead. Returns the
/// lanes that have one for certain, and are done. A lane is told only if it begins above the
/// surface by more than f's error, and is below it by more than that while still inside its cell:
/// then, f being quadratic, its one way down lies in between.
template <bool kInt16, bool kTriangles>
HWY_INLINE MI hitFirstCells(const TerrainCut& cut, const Pools& pools, const MarchTile& tile,
                            const ColumnRays& r, const MarchErrors& e, VF begin, MarchLanes& m,
                            size_t p) {
    const VF w0 = setF(static_cast<float>(tile.w0)), zero = hn::Zero(DF());
    const VF w = hn::Max((begin - r.forward0) / r.forward * setF(0.99999f) - w0, r.wBegin);
    const FirstCells at = firstCells(cut, tile, r, w, m, p);
    if (hn::AllFalse(DI(), at.lanes)) return at.lanes;
    const CellPosts c = loadPosts<kInt16, true>(pools,
                                                {loadI(m.postsOffset + p), loadI(m.postsCode + p),
                                                 loadF(m.postsZ + p), loadF(m.postsStep + p)},
                                                at.cx, at.cy, at.lanes);
    FirstWay k;
    k.u = at.u;
    k.v = at.v;
    k.du = r.dx * at.inverse;
    k.dv = r.dy * at.inverse;
    const VF b = c.h10 - c.h00, a = c.h01 - c.h00, d = (c.h11 - c.h01) - b;
    const VF ground = hn::MulAdd(k.v, hn::MulAdd(d, k.u, a), hn::MulAdd(b, k.u, c.h00));
    const VF grade = hn::Abs(b) + hn::Abs(a) + hn::Abs(d) + hn::Abs(d);
    // Nowhere in the cell is the ground farther from the anchor's height; and the cell is left
    // before w has grown by its size over the ray's speed.
    const VF relief = hn::Abs(ground) + grade;
    const VF farthest = hn::Abs(w) + setF(1.0f) / hn::Max(hn::Abs(k.du), hn::Abs(k.dv));
    const VF shift = hn::MulAdd(setF(e.shift1), farthest, setF(e.shift0)) * at.inverse;
    const VF error = errorIn({farthest, shift, hn::MaskFromVec(zero), grade, relief}, e, 0.0f);
    const VF rim = setF(8.0f) * shift;
    MF second = hn::MaskFromVec(zero);
    if constexpr (kTriangles) {
        chooseTriangle(c, r, w, error, rim, k, second);
    } else {
        k.f0 = hn::MulAdd(w, hn::MulAdd(r.bend, w, r.dz), r.z) - ground;
        const VF climb =
            hn::MulAdd(b, k.du, hn::MulAdd(a, k.dv, d * hn::MulAdd(k.u, k.dv, k.v * k.du)));
        k.slope = hn::MulAdd(r.bend + r.bend, w, r.dz) - climb;
        k.f2 = hn::NegMulAdd(d * k.du, k.dv, r.bend);
        k.lanes = k.f0 > error;
    }
    const MarchRoot root = rootOf(k.f0, k.slope, k.f2);
    // A little beyond the hit f is below -error.
    const VF beyond = root.s + setF(4.0f) * error / root.rate;
    const VF u1 = hn::MulAdd(k.du, beyond, k.u), v1 = hn::MulAdd(k.dv, beyond, k.v);
    MF told = hn::And(k.lanes, hn::And(root.s > zero, isInside(k.u, k.v, rim)));
    told = hn::And(told, isInside(u1, v1, rim));
    told = hn::And(told, setF(8.0f) * hn::Abs(k.f2) * error <= root.rate * root.rate);
    if constexpr (kTriangles) {
        const VF before = setF(1.0f) - k.u - k.v, after = setF(1.0f) - u1 - v1;
        const VF side = hn::IfThenElse(second, hn::Neg(before), before);
        told = hn::And(told, hn::CopySign(after, after * side) > rim + rim);
    }
    const VF hitW = w + (root.s + w0), t = hitW * r.length;
    told = hn::And(told, isPlaced(root, k.slope, r, t, error, e.rounding));
    const MI done = hn::AndNot(c.hole, hn::And(at.lanes, maskI(told)));
    storeF(done, t, m.t + p);
    storeF(done, hn::MulAdd(k.du, root.s, k.u), m.u + p);
    storeF(done, hn::MulAdd(k.dv, root.s, k.v), m.v + p);
    storeF(done, hn::MulAdd(hitW, r.forward, r.forward0), m.forward + p);
    storeI(done, hn::ShiftLeft<kTileLevels>(at.cy) + at.cx, m.cell + p);
    storeI(done, setI(kMarchHit), m.result + p);
    return done;
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
