// SPDX-License-Identifier: Apache-2.0
// Column marching in SIMD lanes (kernel/columns.h): each lane begins in the cell where its column's
// ray below has hit, and walks a few cells. A lane is decided only where float error cannot matter.

#if defined(TERRAY_COLUMNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_COLUMNS_INL_H_
#undef TERRAY_COLUMNS_INL_H_
#else
#define TERRAY_COLUMNS_INL_H_
#endif

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "hwy/highway.h"
#include "kernel/columns.h"
#include "kernel/simd/columns.h"
#include "kernel/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// Cells that a packet walks before its last few lanes, or all, are left to the tracer.
constexpr int kFewCells = 3, kMostCells = 16;
constexpr size_t kFewLanes = 3;

/// Rays of one packet, relative to the tile's anchor; w counts from w0.
struct ColumnRays {
    VF x, y, z, dx, dy, dz, bend, inverseDx, inverseDy, length, forward0, forward;
    VF wBegin;
};

HWY_INLINE VF inverseOf(VF step) {
    return hn::IfThenElse(hn::Abs(step) < setF(1e-30f), setF(1e30f), setF(1.0f) / step);
}

HWY_INLINE ColumnRays makeRays(const TerrainCut& cut, const MarchTile& tile, const MarchRow& row,
                               size_t p) {
    const auto term = [&](RayTerm k) { return loadF(tile.columns[k] + p) + setF(row.terms[k]); };
    ColumnRays r;
    r.dx = term(kTermDx);
    r.dy = term(kTermDy);
    r.dz = term(kTermDz);
    r.x = term(kTermX);
    r.y = term(kTermY);
    r.z = term(kTermZ);
    const VF length2 = term(kTermLength2);
    r.length = hn::Sqrt(length2);
    r.forward0 = term(kTermForward0);
    r.forward = term(kTermForward);
    r.inverseDx = inverseOf(r.dx);
    r.inverseDy = inverseOf(r.dy);
    const VF w0 = setF(static_cast<float>(tile.w0));
    // |d_h|^2 = length^2 - rise^2: the bend of a ray that covers so much level ground per w
    const VF rise = r.dz * setF(static_cast<float>(tile.exaggeration));
    const VF level = hn::Max(length2 - rise * rise, hn::Zero(DF()));
    r.bend = level * setF(static_cast<float>(tile.bend));
    const VF turned = r.bend * w0;
    r.z = hn::MulAdd(turned, w0, r.z);
    r.dz = r.dz + (turned + turned);
    r.wBegin = hn::Neg(w0);
    if (tile.eyeOutside) {
        const VF left = setF(static_cast<float>(-tile.anchorX)) - r.x;
        const VF top = setF(static_cast<float>(-tile.anchorY)) - r.y;
        const VF ax = left * r.inverseDx, ay = top * r.inverseDy;
        const VF bx = hn::MulAdd(setF(static_cast<float>(cut.cellsX)), r.inverseDx, ax);
        const VF by = hn::MulAdd(setF(static_cast<float>(cut.cellsY)), r.inverseDy, ay);
        r.wBegin = hn::Max(r.wBegin, hn::Max(hn::Min(ax, bx), hn::Min(ay, by)));
    }
    return r;
}

/// Bounds of the float rays' errors, the same for a whole packet: height0 + height1 |w| metres, and
/// shift0 + shift1 |w| cells of mip 0.
struct MarchErrors {
    float height0, height1, shift0, shift1;
    float rounding;  ///< of the posts
};

inline MarchErrors errorsOf(const TerrainCut& cut, const MarchTile& tile, const MarchRow& row) {
    const auto reach = [&](RayTerm k) { return tile.reach[k] + std::fabs(row.terms[k]); };
    const float w0 = static_cast<float>(tile.w0), bend = static_cast<float>(tile.bend);
    const float turned = 2.0f * bend * std::fabs(w0) * reach(kTermLength2);
    const float highest = std::max(std::fabs(cut.minZ), std::fabs(cut.maxZ));
    MarchErrors e;
    // A decoded post is rounded to half an ulp; here it is not.
    e.rounding = 0x1.2p-24f * highest;
    e.height0 = kFloatError * (reach(kTermZ) + turned * std::fabs(w0)) + e.rounding;
    e.height1 = 2.0f * kFloatError * (reach(kTermDz) + turned);
    e.shift0 = kFloatError * (1.0f + reach(kTermX) + reach(kTermY));
    e.shift1 = kFloatError * (reach(kTermDx) + reach(kTermDy));
    return e;
}

/// A lane's cell as its ray sees it.
struct MarchCell {
    VF wIn, wOut;
    VF u, v, du, dv;  ///< place at wIn, in the cell; change per w
    VF f0, f1, slope,
        f2;  ///< ray less surface at wIn and wOut; its derivative at wIn; its curvature
    VF low;  ///< least f in between, where it matters
    VF error;
    MI alongX, open;  ///< open: a hole, or not to be told
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
    k.low = hn::Min(hn::IfThenElse(crosses, hn::Min(k.f1, middle), k.f1), k.f0) - sag;
    k.open = hn::Or(k.open, maskI(hn::And(crosses, hn::Abs(middle) <= k.error)));
    const MF beyond = hn::And(crosses, middle > zero);
    k.f0 = hn::IfThenElse(beyond, middle, k.f0);
    k.slope =
        hn::IfThenElse(beyond, hn::MulAdd(r.bend + r.bend, s, k.slope + first - second), k.slope);
    k.u = hn::IfThenElse(beyond, hn::MulAdd(k.du, s, k.u), k.u);
    k.v = hn::IfThenElse(beyond, hn::MulAdd(k.dv, s, k.v), k.v);
    k.wIn = hn::IfThenElse(beyond, k.wIn + s, k.wIn);
}

/// What the error of f in a cell depends on.
struct MarchReach {
    VF u1, v1;   ///< where the ray leaves
    VF w;        ///< largest |w|
    VF inverse;  ///< 1 / the cell's size
    VF grade;    ///< of the cell, metres a cell
    VF relief;   ///< largest height, from the anchor's
};
HWY_INLINE VF errorIn(const MarchReach& k, const MarchErrors& e, float maxDelta) {
    // A ray that leaves near a corner may really pass through the next cell but one: there the
    // surface differs by no more than the steepest ground does over the lattice error.
    const VF one = setF(1.0f);
    const VF shift = hn::MulAdd(setF(e.shift1), k.w, setF(e.shift0)) * k.inverse;
    const VF sideU = hn::Min(hn::Abs(k.u1), hn::Abs(one - k.u1));
    const VF sideV = hn::Min(hn::Abs(k.v1), hn::Abs(one - k.v1));
    const MF corner = hn::Max(sideU, sideV) < setF(8.0f) * shift;
    const VF steepest = hn::IfThenElseZero(corner, setF(4.0f * maxDelta));
    const VF rounding = hn::MulAdd(setF(kFloatError), k.relief + k.grade, setF(e.height0));
    return hn::MulAdd(hn::MulAdd(setF(2.0f), k.grade, steepest), shift,
                      hn::MulAdd(setF(e.height1), k.w, rounding));
}

template <bool kInt16, bool kTriangles>
HWY_INLINE MarchCell lookAt(const TerrainCut& cut, const Pools& pools, const MarchTile& tile,
                            const ColumnRays& r, const MarchErrors& e, const MarchLanes& m,
                            size_t p, VI x, VI y, VI mip, MI lanes) {
    const VI cellMask = setI(kSlotCells - 1);
    const VI cx = hn::And(shiftRight(x, mip), cellMask), cy = hn::And(shiftRight(y, mip), cellMask);
    const CellPosts c = loadPosts<kInt16>(pools,
                                          {loadI(m.postsOffset + p), loadI(m.postsCode + p),
                                           loadF(m.postsZ + p), loadF(m.postsStep + p)},
                                          cx, cy, lanes);
    MarchCell k;
    k.open = c.hole;
    const VI ax = setI(static_cast<int32_t>(tile.anchorX));
    const VI ay = setI(static_cast<int32_t>(tile.anchorY));
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

    k.error = errorIn({u1, v1, hn::Max(hn::Abs(k.wIn), hn::Abs(k.wOut)), inverse,
                       hn::Abs(b) + hn::Abs(a) + hn::Abs(d) + hn::Abs(d),
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
HWY_INLINE MarchStep nextCell(const TerrainCut& cut, const MarchTile& tile, const ColumnRays& r,
                              const MarchCell& k, VI x, VI y, VI mip) {
    const VI one = setI(1), zero = hn::Zero(DI());
    const VI size = shiftLeft(one, mip), last = size - one;
    const VI x0 = hn::AndNot(last, x), y0 = hn::AndNot(last, y);
    const VI acrossX = select(maskI(r.dx >= hn::Zero(DF())), x0 + size, x0 - one);
    const VI acrossY = select(maskI(r.dy >= hn::Zero(DF())), y0 + size, y0 - one);
    const VI ax = setI(static_cast<int32_t>(tile.anchorX));
    const VI ay = setI(static_cast<int32_t>(tile.anchorY));
    MarchStep s;
    s.x = select(k.alongX, acrossX, cellAt(r.x, r.dx, k.wOut, ax, x0, last));
    s.y = select(k.alongX, cellAt(r.y, r.dy, k.wOut, ay, y0, last), acrossY);
    s.outside = hn::Or(hn::Or(s.x < zero, s.y < zero),
                       hn::Or(s.x > setI(cut.cellsX - 1), s.y > setI(cut.cellsY - 1)));
    return s;
}

/// Fixes the hits of a packet: where f goes through zero from above. Returns the lanes for which
/// float arithmetic tells the distance well enough.
HWY_INLINE MI fixHits(const MarchTile& tile, const ColumnRays& r, const MarchCell& k, MarchLanes& m,
                      size_t p, MI hits, float rounding) {
    const VF zero = hn::Zero(DF()), one = setF(1.0f);
    const VF disc = hn::Max(hn::NegMulAdd(setF(4.0f) * k.f2, k.f0, k.slope * k.slope), zero);
    const VF root = hn::Sqrt(disc);  // |f'| at the hit
    const MF falling = k.slope <= zero;
    const VF numerator = hn::IfThenElse(falling, k.f0 + k.f0, hn::Neg(k.slope + root));
    const VF denominator = hn::IfThenElse(falling, root - k.slope, k.f2 + k.f2);
    const VF length = k.wOut - k.wIn;
    const VF s = hn::Min(hn::Max(numerator / denominator, zero), length);
    const VF w = k.wIn + (s + setF(static_cast<float>(tile.w0)));
    const VF t = w * r.length;
    // The tolerance of docs/surface.md: |dt| <= max(1 mm, 1e-5 t, 2 eps / |f'|). Half of it.
    const VF allowed = hn::Max(setF(5e-4f), t * setF(5e-6f));
    const MF near = hn::Or(k.error * r.length <= allowed * root, k.error <= setF(2.0f * rounding));
    const MF steady = disc > setF(1e-3f) * (k.slope * k.slope);
    storeF(hits, t, m.t + p);
    storeF(hits, hn::Min(hn::Max(hn::MulAdd(k.du, s, k.u), zero), one), m.u + p);
    storeF(hits, hn::Min(hn::Max(hn::MulAdd(k.dv, s, k.v), zero), one), m.v + p);
    storeF(hits, hn::MulAdd(w, r.forward, r.forward0), m.forward + p);
    return hn::And(hits, maskI(hn::And(near, steady)));
}

/// Ends the lanes that have hit their cell (x, y).
HWY_INLINE void storeHits(const MarchTile& tile, const ColumnRays& r, const MarchCell& k,
                          const MarchErrors& e, MarchLanes& m, size_t p, VI x, VI y, VI mip,
                          MI hits) {
    if (hn::AllFalse(DI(), hits)) return;
    const MI fixed = fixHits(tile, r, k, m, p, hits, e.rounding);
    const VI cellMask = setI(kSlotCells - 1);
    const VI cx = hn::And(shiftRight(x, mip), cellMask);
    const VI cy = hn::And(shiftRight(y, mip), cellMask);
    storeI(fixed, hn::ShiftLeft<kTileLevels>(cy) + cx, m.cell + p);
    storeI(fixed, setI(kMarchHit), m.result + p);
}

/// Lanes that have nothing before them at w: beyond the rim, or rising above all ground.
HWY_INLINE MI isPast(const TerrainCut& cut, const MarchTile& tile, const MarchErrors& e,
                     const ColumnRays& r, VF w, MI outside) {
    const VF left = setF(static_cast<float>(-tile.anchorX)) - r.x;
    const VF top = setF(static_cast<float>(-tile.anchorY)) - r.y;
    const VF ax = left * r.inverseDx, ay = top * r.inverseDy;
    const VF bx = hn::MulAdd(setF(static_cast<float>(cut.cellsX)), r.inverseDx, ax);
    const VF by = hn::MulAdd(setF(static_cast<float>(cut.cellsY)), r.inverseDy, ay);
    const MI beyond = hn::And(outside, maskI(w >= hn::Min(hn::Max(ax, bx), hn::Max(ay, by))));
    const VF z = hn::MulAdd(w, hn::MulAdd(r.bend, w, r.dz), r.z);
    const VF error = hn::MulAdd(setF(e.height1), hn::Abs(w), setF(e.height0));
    const VF highest = setF(cut.maxZ - static_cast<float>(tile.anchorZ));
    const MF above =
        hn::And(z - error > highest, hn::MulAdd(r.bend + r.bend, w, r.dz) > setF(e.height1));
    return hn::Or(beyond, maskI(above));
}

/// Metres ahead from which on the rays may meet the surface; negative: not known.
HWY_INLINE VF beginOf(const MarchRow& row, const MarchLanes& m, size_t p) {
    VF begin = loadF(m.limit + p);
    for (int k = row.first; k <= row.last; ++k)
        begin = hn::Min(begin, hn::LoadU(DF(), m.below + p + k));
    return begin;
}

/// Where the lanes of a packet stand.
struct MarchPlace {
    VI x, y, mip;
    MI active;
};

/// Puts lanes where the row below says, a little before: for its rounding, and this division's.
HWY_INLINE MarchPlace beginLanes(const TerrainCut& cut, const MarchTile& tile, const MarchErrors& e,
                                 const ColumnRays& r, VF begin, MarchLanes& m, size_t p,
                                 MI active) {
    const VI zero = hn::Zero(DI());
    const VF w0 = setF(static_cast<float>(tile.w0));
    const VF ahead = (begin - r.forward0) / r.forward * setF(0.99999f) - w0;
    const VF w = hn::Max(ahead, r.wBegin);
    const VF px = hn::MulAdd(r.dx, w, r.x), py = hn::MulAdd(r.dy, w, r.y);
    const VI x = hn::ConvertTo(DI(), hn::Floor(px)) + setI(static_cast<int32_t>(tile.anchorX));
    const VI y = hn::ConvertTo(DI(), hn::Floor(py)) + setI(static_cast<int32_t>(tile.anchorY));
    storeF(active, (w * setF(0.9999f) + w0) * r.length, m.clear + p);

    const VI lastX = setI(cut.cellsX - 1), lastY = setI(cut.cellsY - 1);
    const MI outside = hn::Or(hn::Or(x < zero, y < zero), hn::Or(x > lastX, y > lastY));
    const MI past = hn::And(active, hn::Ne(loadI(m.past + p), zero));
    MI gone = noLanes();
    if (!hn::AllFalse(DI(), past)) {
        gone = hn::And(past, isPast(cut, tile, e, r, w, outside));
        storeI(gone, setI(kMarchMiss), m.result + p);
        storeF(gone, begin, m.forward + p);
    }
    return {hn::Min(hn::Max(x, zero), lastX), hn::Min(hn::Max(y, zero), lastY), zero,
            hn::AndNot(hn::Or(outside, gone), active)};
}

/// Looks up the tiles of lanes that have left theirs; ends those that are where nothing is drawn.
HWY_INLINE void enterTiles(const TerrainCut& cut, const MarchTile& tile, MarchLanes& m, size_t p,
                           MarchPlace& place) {
    place.mip = loadI(m.mip + p);
    const VI elsewhere = shiftRight(
        hn::Or(hn::Xor(place.x, loadI(m.tileX + p)), hn::Xor(place.y, loadI(m.tileY + p))),
        place.mip + setI(kTileLevels));
    const MI moved = hn::And(place.active, hn::Ne(elsewhere, hn::Zero(DI())));
    if (hn::AllFalse(DI(), moved)) return;
    alignas(64) int32_t x[16], y[16], which[16];
    hn::Store(place.x, DI(), x);
    hn::Store(place.y, DI(), y);
    hn::Store(hn::IfThenElseZero(moved, setI(1)), DI(), which);
    enterMarchTiles(cut, tile.anchorZ, x, y, which, static_cast<int>(hn::Lanes(DI())), m,
                    static_cast<int>(p));
    place.mip = loadI(m.mip + p);
    const MI nothing = hn::Eq(loadI(m.slot + p), setI(static_cast<int32_t>(kNoSlot)));
    place.active = hn::AndNot(nothing, place.active);
}

template <bool kInt16, bool kTriangles>
void marchPacket(const TerrainCut& cut, const Pools& pools, const MarchTile& tile,
                 const MarchRow& row, const MarchErrors& e, MarchLanes& m, size_t p) {
    const VI zero = hn::Zero(DI());
    const VF begin = beginOf(row, m, p), w0 = setF(static_cast<float>(tile.w0));
    const MI begun = maskI(begin >= hn::Zero(DF()));
    hn::Store(zero, DI(), m.result + p);
    hn::Store(zero, DI(), m.steps + p);
    hn::Store(hn::IfThenElseZero(begun, setI(1)), DI(), m.begun + p);
    hn::Store(setF(-1.0f), DF(), m.forward + p);
    if (hn::AllFalse(DI(), begun)) return;
    const ColumnRays r = makeRays(cut, tile, row, p);
    MarchPlace place = beginLanes(cut, tile, e, r, begin, m, p, begun);
    MI hits = noLanes();
    VI steps = zero;
    for (int cell = 0; cell < kMostCells && !hn::AllFalse(DI(), place.active); ++cell) {
        enterTiles(cut, tile, m, p, place);
        const VI x = place.x, y = place.y;
        const MarchCell k = lookAt<kInt16, kTriangles>(cut, pools, tile, r, e, m, p, x, y,
                                                       place.mip, hn::Or(place.active, hits));
        const MI told = hn::AndNot(k.open, hn::And(place.active, maskI(k.f0 > k.error)));
        const MI passes = hn::And(told, maskI(k.low > k.error));
        hits = hn::Or(hits, hn::And(told, maskI(k.low < hn::Neg(k.error))));
        steps = steps + hn::IfThenElseZero(place.active, setI(1));
        place.active = noLanes();
        if (!hn::AllFalse(DI(), passes)) {
            const MarchStep next = nextCell(cut, tile, r, k, x, y, place.mip);
            const MI gone = hn::And(passes, next.outside);
            place.active = hn::AndNot(next.outside, passes);
            place.x = select(place.active, next.x, x);
            place.y = select(place.active, next.y, y);
            storeI(gone, setI(kMarchMiss), m.result + p);
            storeF(gone, hn::MulAdd(k.wOut + w0, r.forward, r.forward0), m.forward + p);
            storeF(passes, (k.wOut + w0) * r.length, m.clear + p);
        }
        const size_t left = hn::CountTrue(DI(), place.active);
        if (left == 0 || cell + 1 == kMostCells || (left < kFewLanes && cell + 1 >= kFewCells)) {
            storeHits(tile, r, k, e, m, p, x, y, place.mip, hits);
            break;
        }
    }
    hn::Store(steps, DI(), m.steps + p);
}

/// The hits of lanes [p, p + lanes), of which the columns [begin, end) are wanted.
void writeHits(const MarchLanes& m, int p, int begin, int end, Hit* hits) {
    for (int c = std::max(p, begin); c < std::min(p + static_cast<int>(hn::Lanes(DF())), end);
         ++c) {
        hits[c] = {m.t[c],
                   static_cast<uint32_t>(m.slot[c]),
                   static_cast<uint32_t>(m.cell[c]),
                   m.u[c],
                   m.v[c],
                   static_cast<uint16_t>(m.steps[c]),
                   static_cast<uint8_t>(m.mip[c]),
                   m.result[c] == kMarchHit ? uint8_t{kHitValid} : uint8_t{0}};
    }
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void writeAllHits(const MarchLanes& m, size_t p, Hit* hits) {
    writeHits(m, static_cast<int>(p), static_cast<int>(p), static_cast<int>(p) + 1, hits);
}
#else
/// The hits of a packet. Two hits are three blocks of 16 bytes: (t, slot, cell, u), (v, rest, t,
/// slot), (cell, u, v, rest); each block of the vectors below belongs to two neighbours.
HWY_INLINE void writeAllHits(const MarchLanes& m, size_t p, Hit* hits) {
    static_assert(sizeof(Hit) == 24 && offsetof(Hit, cell) == 8 && offsetof(Hit, v) == 16);
    const hn::RepartitionToWide<DU> d64;
    const DU d;
    const auto bits = [&](const auto* from) {
        return hn::Load(d, reinterpret_cast<const uint32_t*>(from + p));
    };
    const auto t = bits(m.t), slot = bits(m.slot), cell = bits(m.cell), u = bits(m.u),
               v = bits(m.v);
    const auto valid = hn::IfThenElseZero(hn::Eq(bits(m.result), hn::Set(d, kMarchHit)),
                                          hn::Set(d, uint32_t{kHitValid} << 24));
    const auto rest = hn::Or(hn::Or(bits(m.steps), hn::ShiftLeft<16>(bits(m.mip))), valid);
    alignas(64) uint64_t blocks[3][8];
    const auto write = [&](auto a, auto b, auto c, size_t first) {
        hn::Store(hn::InterleaveLower(d64, a, b), d64, blocks[0]);
        hn::Store(hn::OddEven(a, c), d64, blocks[1]);
        hn::Store(hn::InterleaveUpper(d64, b, c), d64, blocks[2]);
        for (size_t k = 0; k < hn::Lanes(d); k += 4)
            for (size_t part = 0; part < 3; ++part)
                std::memcpy(reinterpret_cast<char*>(hits + p + k + first) + 16 * part,
                            blocks[part] + k / 2, 16);
    };
    const auto wide = [&](auto x) { return hn::BitCast(d64, x); };
    write(wide(hn::InterleaveLower(d, t, slot)), wide(hn::InterleaveLower(d, cell, u)),
          wide(hn::InterleaveLower(d, v, rest)), 0);
    write(wide(hn::InterleaveUpper(d, t, slot)), wide(hn::InterleaveUpper(d, cell, u)),
          wide(hn::InterleaveUpper(d, v, rest)), 2);
}
#endif

MarchCounts marchRowLanes(const TerrainCut& cut, const MarchTile& tile, const MarchRow& row,
                          int begin, int end, MarchLanes& m, Hit* hits) {
    const Pools pools = makePools(cut, static_cast<float>(tile.anchorZ));
    const MarchErrors e = errorsOf(cut, tile, row);
    constexpr int kLanes = static_cast<int>(HWY_LANES(float) < 16 ? HWY_LANES(float) : 16);
    const bool triangles = cut.surface == kSurfaceTriangles, int16 = cut.format == 0;
    const auto march = int16 ? (triangles ? marchPacket<true, true> : marchPacket<true, false>)
                             : (triangles ? marchPacket<false, true> : marchPacket<false, false>);
    MarchCounts counts;
    for (int p = begin / kLanes * kLanes; p < end; p += kLanes) {
        const auto first = static_cast<size_t>(p);
        march(cut, pools, tile, row, e, m, first);
        const VI result = loadI(m.result + p);
        const MI missed = hn::Eq(result, setI(kMarchMiss));
        hn::Store(hn::IfThenElseZero(missed, setI(1)), DI(), m.past + p);
        if (p >= begin && p + kLanes <= end) {
            const int hit = static_cast<int>(hn::CountTrue(DI(), hn::Eq(result, setI(kMarchHit))));
            counts.hits += hit;
            counts.left += kLanes - hit - static_cast<int>(hn::CountTrue(DI(), missed));
            counts.steps += hn::GetLane(hn::SumOfLanes(DI(), loadI(m.steps + p)));
            writeAllHits(m, first, hits);
            continue;
        }
        writeHits(m, p, begin, end, hits);
        for (int c = std::max(p, begin); c < std::min(p + kLanes, end); ++c) {
            counts.hits += m.result[c] == kMarchHit;
            counts.left += m.result[c] == kMarchLeft;
            counts.steps += m.steps[c];
        }
    }
    return counts;
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
