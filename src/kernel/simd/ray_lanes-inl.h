// SPDX-License-Identifier: Apache-2.0
// Double-precision lanes: clipping and placing rays, and the root of a hit's cell. The same
// formulas as kernel/exact, whose comments say why they are what they are.

#if defined(TERRAY_RAY_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_RAY_LANES_INL_H_
#undef TERRAY_RAY_LANES_INL_H_
#else
#define TERRAY_RAY_LANES_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "hwy/highway.h"
#include "kernel/simd/ray_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DD = hn::CappedTag<double, 8>;
using DDF = hn::Rebind<float, DD>;
using DDI = hn::Rebind<int32_t, DD>;
using VD = hn::Vec<DD>;
using MD = hn::Mask<DD>;

HWY_INLINE VD loadD(const double* p) { return hn::Load(DD(), p); }
HWY_INLINE VD setD(double v) { return hn::Set(DD(), v); }
HWY_INLINE void storeFloat(VD v, float* p) { hn::Store(hn::DemoteTo(DDF(), v), DDF(), p); }
HWY_INLINE void storeInt(VD v, int32_t* p) { hn::Store(hn::DemoteTo(DDI(), v), DDI(), p); }
HWY_INLINE VD clampD(VD v, VD lo, VD hi) { return hn::Min(hn::Max(v, lo), hi); }
/// Magnitude of `a` with the sign of `b`; -0 counts as negative, as in std::copysign.
HWY_INLINE VD withSign(VD a, VD b) { return hn::CopySign(a, b); }

struct ClipD {
    VD begin, end;
};

/// The slab 0 <= o + d t <= size, where d is not zero.
HWY_INLINE void clipSlab(ClipD& c, VD origin, VD step, VD inverse, double size) {
    const VD zero = hn::Zero(DD());
    const VD a = hn::Neg(origin) * inverse, b = (setD(size) - origin) * inverse;
    const MD level = step == zero;
    const MD outside = hn::And(level, hn::Or(origin<zero, origin> setD(size)));
    c.begin = hn::IfThenElse(level, c.begin, hn::Max(c.begin, hn::Min(a, b)));
    c.end = hn::IfThenElse(level, c.end, hn::Min(c.end, hn::Max(a, b)));
    c.end = hn::IfThenElse(outside, setD(-1e300), c.end);
}

/// The part of the ray below z = top: between the roots of a convex parabola, or a half line.
HWY_INLINE void clipTop(ClipD& c, VD z, VD dz, VD bend, double top) {
    const VD slack = hn::MulAdd(setD(1e-9), hn::Abs(z) + setD(top < 0 ? -top : top), setD(1e-6));
    const VD above = z - (setD(top) + slack), zero = hn::Zero(DD());
    const VD disc = dz * dz - setD(4.0) * bend * above;
    const VD k = setD(-0.5) * (dz + withSign(hn::Sqrt(hn::Max(disc, zero)), dz));
    const VD r1 = k / bend, r2 = above / k;
    const MD flat = hn::And(dz == zero, bend == zero);
    const VD first = hn::IfThenElse(flat, c.begin, hn::Min(r1, r2));
    const VD last = hn::IfThenElse(flat, c.end, hn::Max(r1, r2));
    c.begin = hn::Max(c.begin, first);
    c.end = hn::Min(c.end, last);
    const MD never = hn::Or(disc < zero, hn::And(flat, above > zero));
    c.end = hn::IfThenElse(never, setD(-1e300), c.end);
}

/// Ends rays that sink below all there is, for good: under z = bottom up to the end.
HWY_INLINE void clipBottom(ClipD& c, VD z, VD dz, VD bend, double bottom) {
    const VD slack = hn::MulAdd(setD(1e-9), hn::Abs(z) + setD(std::fabs(bottom)), setD(1e-6));
    const VD above = z - (setD(bottom) - slack), zero = hn::Zero(DD());
    const VD disc = dz * dz - setD(4.0) * bend * above;
    const MD sinks = hn::And(hn::And(dz<zero, above> zero), disc > zero);
    const VD k = setD(0.5) * (hn::Sqrt(hn::Max(disc, zero)) - dz);  // > 0
    const VD first = above / k, second = k / bend;  // infinite where the ray is straight
    const MD forGood = hn::And(sinks, second >= c.end);
    c.end = hn::IfThenElse(forGood, hn::Min(c.end, first), c.end);
}

HWY_INLINE void placeAt(const TerrainCut& cut, const RayBatch& r, RayBlock& b, size_t p,
                        const ClipD& c, VD inverseX, VD inverseY) {
    const MD some = c.begin <= c.end;
    const VD zero = hn::Zero(DD()), big = setD(1e30), begin = hn::IfThenElseZero(some, c.begin);
    const VD dx = loadD(r.dx + p), dy = loadD(r.dy + p), bend = loadD(r.bend + p);
    const VD px = hn::MulAdd(dx, begin, loadD(r.x + p)), py = hn::MulAdd(dy, begin, loadD(r.y + p));
    const VD cx = clampD(hn::Floor(px), zero, setD(cut.cellsX - 1));
    const VD cy = clampD(hn::Floor(py), zero, setD(cut.cellsY - 1));
    const VD belowOne = setD(0.99999994);
    storeInt(cx, b.anchorX + p);
    storeInt(cy, b.anchorY + p);
    storeInt(cx, b.x + p);
    storeInt(cy, b.y + p);
    storeFloat(clampD(px - cx, zero, belowOne), b.fx + p);
    storeFloat(clampD(py - cy, zero, belowOne), b.fy + p);
    const VD tiny = setD(1e-30);
    const MD noX = hn::Abs(dx) < tiny, noY = hn::Abs(dy) < tiny;
    storeFloat(hn::IfThenZeroElse(noX, dx), b.dx + p);
    storeFloat(hn::IfThenZeroElse(noY, dy), b.dy + p);
    storeFloat(hn::IfThenElse(noX, big, inverseX), b.inverseDx + p);
    storeFloat(hn::IfThenElse(noY, big, inverseY), b.inverseDy + p);
    const VD dz0 = loadD(r.dz + p);
    const VD z = hn::MulAdd(begin, hn::MulAdd(bend, begin, dz0), loadD(r.z + p)) -
                 setD(static_cast<double>(0.5f * (cut.minZ + cut.maxZ)));
    const VD dz = hn::MulAdd(bend + bend, begin, dz0);
    const VD length = hn::IfThenElseZero(some, c.end - begin);
    storeFloat(z, b.z + p);
    storeFloat(dz, b.dz + p);
    storeFloat(bend, b.bend + p);
    const VD vertex = clampD(hn::Neg(dz) / (bend + bend), hn::Neg(big), big);
    const VD straight = hn::IfThenElse(dz < zero, big, hn::Neg(big));
    storeFloat(hn::IfThenElse(bend > zero, vertex, straight), b.vertex + p);
    storeFloat(hn::Min(length, big) * setD(1.000001), b.tEnd + p);
    const VD error = setD(static_cast<double>(kFloatError));
    // Heights are relative to the middle of the range: no operand is larger than this.
    const float span = std::max(0.5f * (cut.maxZ - cut.minZ), cut.codeReach);
    const VD reach = hn::Max(hn::Abs(z), setD(static_cast<double>(span) + 1e-3));
    const VD error0 = hn::MulAdd(error, reach, setD(static_cast<double>(decodingError(cut))));
    const VD error1 = error * hn::MulAdd(bend + bend, hn::Min(length, big), hn::Abs(dz));
    const VD shift1 = error * (hn::Abs(dx) + hn::Abs(dy));
    const VD twice = setD(2.0 * static_cast<double>(cut.maxDelta));
    storeFloat(error0, b.error0 + p);
    storeFloat(error1, b.error1 + p);
    storeFloat(shift1, b.shift1 + p);
    storeFloat(hn::MulAdd(twice, setD(static_cast<double>(kShift0)), error0), b.anywhere0 + p);
    storeFloat(hn::MulAdd(twice, shift1, error1), b.anywhere1 + p);
    storeInt(hn::IfThenElseZero(some, setD(kLaneDirectory)), b.state + p);
}

void placeRayBatch(const TerrainCut& cut, RayBatch& r, RayBlock& b, int count, int startLevel) {
    constexpr size_t kLanes = HWY_LANES(double) < 8 ? HWY_LANES(double) : 8;
    for (size_t p = 0; p < static_cast<size_t>(count); p += kLanes) {
        ClipD c{loadD(r.begin + p), loadD(r.end + p)};
        const VD dx = loadD(r.dx + p), dy = loadD(r.dy + p);
        const VD inverseX = setD(1.0) / dx, inverseY = setD(1.0) / dy;
        clipSlab(c, loadD(r.x + p), dx, inverseX, cut.cellsX);
        clipSlab(c, loadD(r.y + p), dy, inverseY, cut.cellsY);
        clipTop(c, loadD(r.z + p), loadD(r.dz + p), loadD(r.bend + p),
                static_cast<double>(cut.maxZ));
        clipBottom(c, loadD(r.z + p), loadD(r.dz + p), loadD(r.bend + p),
                   static_cast<double>(cut.minZ));
        hn::Store(c.begin, DD(), r.begin + p);
        hn::Store(c.end, DD(), r.end + p);
        c.begin = hn::Max(c.begin, loadD(r.clear + p));
        placeAt(cut, r, b, p, c, inverseX, inverseY);
    }
    const int32_t top = std::max(cut.rootLevel - 1, 0) + kTileLevels;
    const int32_t level = std::min(top, std::max(startLevel, kTileLevels));
    for (int k = 0; k < count; ++k) {
        b.t[k] = 0.0f;
        b.level[k] = level;
        b.steps[k] = b.side[k] = b.below[k] = b.slot[k] = b.mip[k] = 0;
        b.result[k] = kResultMiss;
        b.entryLevel[k] = startLevel;
        b.boundsOffset[k] = b.postsOffset[k] = 0;
        b.boundsZ[k] = b.boundsStep[k] = b.postsZ[k] = b.postsStep[k] = b.tileDelta[k] = 0.0f;
    }
}

/// Interval of t inside the cell [lo, lo + 1] of one axis.
HWY_INLINE void clipCell(ClipD& c, VD origin, VD step, VD lo) {
    const VD inverse = setD(1.0) / step;
    const VD a = (lo - origin) * inverse, b = (lo + setD(1.0) - origin) * inverse;
    const MD level = step == hn::Zero(DD());
    c.begin = hn::IfThenElse(level, c.begin, hn::Max(c.begin, hn::Min(a, b)));
    c.end = hn::IfThenElse(level, c.end, hn::Min(c.end, hn::Max(a, b)));
}

/// The first root of f0 + f1 s + f2 s^2 between `from` and `to`; `never` if there is none.
HWY_INLINE VD firstRootIn(VD f0, VD f1, VD f2, VD from, VD to, VD never) {
    const VD disc = hn::Max(f1 * f1 - setD(4.0) * f2 * f0, hn::Zero(DD()));
    const VD k = setD(-0.5) * (f1 + withSign(hn::Sqrt(disc), f1));
    const VD r1 = k / f2, r2 = f0 / k;
    const VD s1 = hn::IfThenElse(hn::And(r1 >= from, r1 <= to), r1, never);
    const VD s2 = hn::IfThenElse(hn::And(r2 >= from, r2 <= to), r2, never);
    return hn::Min(s1, s2);
}

/// Two triangles in the order of the ray: surface = lower plane + hd max(u + v - 1, 0). `plane` and
/// `slope`: ray less lower plane at the cell's entry.
HWY_INLINE VD firstRootOfTriangles(VD plane, VD slope, VD bend, VD hd, VD beyond, VD rate,
                                   VD length, VD never) {
    const VD zero = hn::Zero(DD());
    const MD startsUpper = hn::Or(beyond > zero, hn::And(beyond == zero, rate > zero));
    const VD upperPlane = plane - hd * beyond, upperSlope = slope - hd * rate;
    const VD meets = hn::Neg(beyond) / rate, slack = length * setD(1e-9);
    const VD middle = hn::IfThenElse(hn::And(meets > zero, meets < length), meets, length);
    const VD f0 = hn::IfThenElse(startsUpper, upperPlane, plane);
    const VD f1 = hn::IfThenElse(startsUpper, upperSlope, slope);
    // Only of the two triangles together is a root known; the first may have none.
    const MD none = f1 * f1 < setD(4.0) * bend * f0;
    const VD s1 =
        hn::IfThenElse(none, never, firstRootIn(f0, f1, bend, zero, middle + slack, never));
    const VD s2 = firstRootIn(hn::IfThenElse(startsUpper, plane, upperPlane),
                              hn::IfThenElse(startsUpper, slope, upperSlope), bend, middle - slack,
                              length + slack, never);
    return hn::IfThenElse(s1 < never, s1, hn::IfThenElse(middle < length, s2, never));
}

template <bool kTriangles>
void finishLanes(const RayBatch& r, HitLanes& h, int count) {
    constexpr size_t kLanes = HWY_LANES(double) < 8 ? HWY_LANES(double) : 8;
    const VD zero = hn::Zero(DD()), one = setD(1.0), never = setD(1e300);
    for (size_t p = 0; p < static_cast<size_t>(count); p += kLanes) {
        // 2^-mip: mips are small, so the product of exact halves is exact
        const VD mip = hn::PromoteTo(DD(), hn::Load(DDI(), h.mip + p));
        const VD scale = hn::BitCast(
            DD(), hn::ShiftLeft<52>(hn::ConvertTo(hn::RebindToSigned<DD>(), setD(1023.0) - mip)));
        const VD x = loadD(r.x + p) * scale, y = loadD(r.y + p) * scale;
        const VD dx = loadD(r.dx + p) * scale, dy = loadD(r.dy + p) * scale;
        const VD z = loadD(r.z + p), dz = loadD(r.dz + p), bend = loadD(r.bend + p);
        const VD cx = loadD(h.cellX + p), cy = loadD(h.cellY + p);
        ClipD c{loadD(r.begin + p), loadD(r.end + p)};
        clipCell(c, x, dx, cx);
        clipCell(c, y, dy, cy);
        const VD u = clampD(hn::MulAdd(dx, c.begin, x) - cx, zero, one);
        const VD v = clampD(hn::MulAdd(dy, c.begin, y) - cy, zero, one);
        const VD h00 = loadD(h.h00 + p);
        const VD hb = loadD(h.h10 + p) - h00, hc = loadD(h.h01 + p) - h00;
        const VD hd = (loadD(h.h11 + p) - loadD(h.h01 + p)) - hb;
        const VD height = hn::MulAdd(c.begin, hn::MulAdd(bend, c.begin, dz), z);
        const VD rise = hn::MulAdd(bend + bend, c.begin, dz);
        const VD length = c.end - c.begin;
        VD f0, s;
        if constexpr (kTriangles) {
            const VD plane = height - hn::MulAdd(hc, v, hn::MulAdd(hb, u, h00));
            const VD beyond = (u + v) - one;
            f0 = plane - hd * hn::Max(beyond, zero);
            s = firstRootOfTriangles(plane, rise - (hb * dx + hc * dy), bend, hd, beyond, dx + dy,
                                     length, never);
        } else {
            f0 = height - hn::MulAdd(v, hn::MulAdd(hd, u, hc), hn::MulAdd(hb, u, h00));
            const VD f1 = rise - (hb * dx + hc * dy + hd * hn::MulAdd(u, dy, v * dx));
            s = firstRootIn(f0, f1, bend - hd * dx * dy, zero, length * setD(1.000000001), never);
        }
        const VD t = c.begin + hn::Min(s, length);
        const MD found = hn::And(s<never, length> zero);
        hn::Store(hn::IfThenElse(found, t, setD(HUGE_VAL) - setD(HUGE_VAL)), DD(), h.t + p);
        storeFloat(clampD(hn::MulAdd(dx, t, x) - cx, zero, one), h.u + p);
        storeFloat(clampD(hn::MulAdd(dy, t, y) - cy, zero, one), h.v + p);
        storeInt(hn::IfThenElseZero(f0 < zero, one), h.fromBelow + p);
    }
}

void finishHitLanes(const RayBatch& r, HitLanes& h, int count, SurfaceKind surface) {
    if (surface == kSurfaceTriangles)
        finishLanes<true>(r, h, count);
    else
        finishLanes<false>(r, h, count);
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
