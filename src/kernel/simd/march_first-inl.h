// SPDX-License-Identifier: Apache-2.0
// The short way of the column march: hits inside the very cell in which a ray begins, told without
// the cell's borders (docs/traversal.md, "Columns").

#if defined(TERRAY_MARCH_FIRST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_MARCH_FIRST_INL_H_
#undef TERRAY_MARCH_FIRST_INL_H_
#else
#define TERRAY_MARCH_FIRST_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "hwy/highway.h"
#include "kernel/columns.h"
#include "kernel/simd/march_cell-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// sqrt(x) and 1 / sqrt(x); 1 / x; to about 2 ulp, for normal positive x: estimates of 14 bits and
/// a Newton step where there are such, else exact.
struct Roots {
    VF root, inverse;
};
#if HWY_TARGET <= HWY_AVX3
HWY_INLINE Roots rootsOf(VF x) {
    const VF y = hn::ApproximateReciprocalSqrt(x);
    const VF root = x * y;
    const VF off = hn::NegMulAdd(root, setF(0.5f) * y, setF(0.5f));
    return {hn::MulAdd(root, off, root), hn::MulAdd(y, off, y)};
}
HWY_INLINE VF inverseNear(VF x) {
    const VF y = hn::ApproximateReciprocal(x);
    return hn::MulAdd(y, hn::NegMulAdd(x, y, setF(1.0f)), y);
}
#else
HWY_INLINE Roots rootsOf(VF x) {
    const VF root = hn::Sqrt(x);
    return {root, setF(1.0f) / root};
}
HWY_INLINE VF inverseNear(VF x) { return setF(1.0f) / x; }
#endif

HWY_INLINE float powerOf2(int32_t k) {
    return std::bit_cast<float>(static_cast<uint32_t>(127 + k) << 23);
}

/// Makes the tile of a calm packet. False if cells do not align with the anchor.
inline bool standOn(const TerrainCut& cut, const MarchGroup& group, const MarchLanes& m, size_t p,
                    MarchPlateau& k) {
    const int32_t mip = m.mip[p], x = m.tileX[p], y = m.tileY[p];
    k.inverse = powerOf2(-mip);
    k.size = powerOf2(mip);
    k.x = (x - group.anchorX) >> mip;
    k.y = (y - group.anchorY) >> mip;
    k.endX = std::min(((cut.cellsX - 1 - x) >> mip) + 1, kSlotCells);
    k.endY = std::min(((cut.cellsY - 1 - y) >> mip) + 1, kSlotCells);
    k.slot = m.slot[p];
    k.mip = mip;
    k.postsOffset = m.postsOffset[p];
    k.postsCode = m.postsCode[p];
    k.postsZ = m.postsZ[p];
    k.postsStep = m.postsStep[p];
    return ((group.anchorX | group.anchorY) & ((1 << mip) - 1)) == 0;
}

/// The surface in a cell: h00 + b u + a v + d u v; over two triangles h00 + b u + a v + d max(u + v
/// - 1, 0).
struct CellShape {
    VF h00, b, a, d;
    MI hole;
};
template <bool kInt16>
HWY_INLINE CellShape firstShape(const TerrainCut& cut, const Pools& pools, const MarchPlateau& in,
                                float anchorZ, VI cx, VI cy) {
    const char* posts = reinterpret_cast<const char*>(pools.posts) + in.postsOffset;
    const VI index = cy * setI(kPostStride) + cx;
    CellShape c;
    c.hole = noLanes();
    if constexpr (kInt16) {
        const VI bytes = index + index;
        const auto* row = reinterpret_cast<const int32_t*>(posts);
        const auto* next = reinterpret_cast<const int32_t*>(posts + 2 * kPostStride);
        VI row0, row1;
        const int32_t first = hn::GetLane(bytes);
        if (hn::AllTrue(DI(), hn::Eq(bytes, setI(first)))) {
            int32_t pair[2];
            std::memcpy(&pair[0], posts + first, sizeof pair[0]);
            std::memcpy(&pair[1], posts + first + 2 * kPostStride, sizeof pair[1]);
            row0 = setI(pair[0]);
            row1 = setI(pair[1]);
        } else {
            row0 = hn::GatherOffset(DI(), row, bytes);
            row1 = hn::GatherOffset(DI(), next, bytes);
        }
        const VI low = setI(0xFFFF);
        const VI q00 = hn::And(row0, low), q01 = hn::And(row1, low);
        const VI q10 = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), row0)));
        const VI q11 = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), row1)));
        if (cut.hasHoles != 0) c.hole = hn::Eq(hn::Max(hn::Max(q00, q10), hn::Max(q01, q11)), low);
        const VI b = q10 - q00;
        const VF step = setF(in.postsStep);
        c.h00 = hn::MulAdd(step, hn::ConvertTo(DF(), q00 - setI(in.postsCode)), setF(in.postsZ));
        c.b = step * hn::ConvertTo(DF(), b);
        c.a = step * hn::ConvertTo(DF(), q01 - q00);
        c.d = step * hn::ConvertTo(DF(), (q11 - q01) - b);
    } else {
        const VI bytes = hn::ShiftLeft<2>(index);
        const auto* row = reinterpret_cast<const float*>(posts);
        const auto* next = row + kPostStride;
        const VF h00 = hn::GatherOffset(DF(), row, bytes);
        const VF h10 = hn::GatherOffset(DF(), row + 1, bytes);
        const VF h01 = hn::GatherOffset(DF(), next, bytes);
        const VF h11 = hn::GatherOffset(DF(), next + 1, bytes);
        c.h00 = h00 - setF(anchorZ);
        c.b = h10 - h00;
        c.a = h01 - h00;
        c.d = (h11 - h01) - c.b;
        if (cut.hasHoles != 0) c.hole = hn::Not(maskI(c.d == c.d));
    }
    return c;
}

/// f = ray less surface along a ray, s counting from where it stands: f0 + slope s + f2 s^2.
struct FirstWay {
    VF f0, slope, f2;
    MF above;  ///< it stands above the surface
    MF lanes;  ///< of which f is true up to the root
};

/// How far aside a place is from the middle of the unit square.
HWY_INLINE VF offMiddle(VF u, VF v) {
    return hn::Max(hn::Abs(u - setF(0.5f)), hn::Abs(v - setF(0.5f)));
}

/// Whole numbers as such: exact below 2^22, else anything.
HWY_INLINE VI wholeOf(VF x) {
    const VF magic = setF(0x1.8p23f);
    return hn::BitCast(DI(), x + magic) - hn::BitCast(DI(), magic);
}

/// A ray over a cell: place and change per w.
struct OverCell {
    VF u, v, du, dv, height, rise;
};

/// f over the bilinear surface.
HWY_INLINE FirstWay overPatch(const CellShape& c, const OverCell& k, VF bend, VF ground, VF alongV,
                              VF error) {
    FirstWay way;
    way.f0 = k.height - ground;
    way.slope = k.rise - hn::MulAdd(hn::MulAdd(c.d, k.v, c.b), k.du, alongV * k.dv);
    way.f2 = hn::NegMulAdd(c.d * k.du, k.dv, bend);
    way.above = way.lanes = way.f0 > error;
    return way;
}

/// Two triangles, along a ray: u + v - 1 and its change per w, f over the lower one and its slope.
struct Diagonal {
    VF m0, dm, lower0, lowerSlope;
    MF upper,
        crosses;  ///< stands over the upper one; is above the surface where it meets the other
    VF beyond, change;  ///< below zero in the triangle that f is of
};
/// f over the triangle that is hit.
HWY_INLINE FirstWay overTriangle(const CellShape& c, const OverCell& k, VF bend, VF ground,
                                 VF error, VF rim, Diagonal& g) {
    const VF zero = hn::Zero(DF());
    g.m0 = (k.u + k.v) - setF(1.0f);
    g.dm = k.du + k.dv;
    g.upper = g.m0 > zero;
    g.lower0 = k.height - ground;
    g.lowerSlope = k.rise - hn::MulAdd(c.b, k.du, c.a * k.dv);
    // At the diagonal both triangles are one. bend >= 0: f is above what it is without.
    const VF size = hn::Abs(g.dm), towards = hn::CopySign(setF(1.0f), g.dm) * g.m0;
    const VF drop = g.lowerSlope * towards;
    g.crosses = hn::And(towards<zero, (g.lower0 - error) * size> drop);
    const MF over = hn::Xor(g.upper, g.crosses);
    const VF upper0 = hn::NegMulAdd(c.d, g.m0, g.lower0);
    FirstWay way;
    way.above = hn::IfThenElse(g.upper, upper0, g.lower0) > error;
    way.lanes = hn::And(way.above, hn::Abs(g.m0) > rim);
    way.f0 = hn::IfThenElse(over, upper0, g.lower0);
    way.slope = hn::IfThenElse(over, hn::NegMulAdd(c.d, g.dm, g.lowerSlope), g.lowerSlope);
    way.f2 = bend;
    g.beyond = hn::IfThenElse(over, hn::Neg(g.m0), g.m0);
    g.change = hn::IfThenElse(over, hn::Neg(g.dm), g.dm);
    return way;
}

/// What came of the short way.
struct FirstHits {
    MF told;    ///< has hit for certain
    MF placed;  ///< and float arithmetic tells well enough where
    MF left;    ///< not followed any further; like all that are not told, above the surface to
                ///< `clear`
    VF t, u, v, forward, clear;
    VI cell, steps;
};

/// A calm packet on the short way, step by step, so that two can take turns: each step is a chain
/// of operations that wait for one another.
template <bool kInt16, bool kTriangles>
class FirstPacket {
public:
    /// The lanes begin `begin` metres ahead; only the wanted ones count.
    HWY_INLINE FirstPacket(const MarchGroup& group, int row, const MarchPlateau& in, VF begin,
                           MF wanted, size_t p)
        : group_(group), in_(in), r_(makeRays(group, row, p)) {
        const VF inverse = setF(in.inverse), zero = hn::Zero(DF());
        const VF ahead = (begin - r_.forward0) * inverseNear(r_.forward);
        w_ = hn::Max(hn::MulSub(ahead, setF(0.99999f), setF(group.w0)), r_.wBegin);
        left_ = hn::Floor(hn::MulAdd(r_.dx, w_, r_.x) * inverse);
        top_ = hn::Floor(hn::MulAdd(r_.dy, w_, r_.y) * inverse);
        cx_ = wholeOf(left_) - setI(in.x);
        cy_ = wholeOf(top_) - setI(in.y);
        k_.du = r_.dx * inverse;
        k_.dv = r_.dy * inverse;
        wanted_ = wanted;
        active_ = hn::And(wanted, begin >= zero);
        told_ = hn::MaskFromVec(zero);
        hitW_ = unsure_ = hitU_ = hitV_ = zero;
        hitCell_ = steps_ = hn::Zero(DI());
        steppedIn_ = false;
    }

    /// All wanted lanes begin at a known place, in the tile.
    HWY_INLINE bool stands() const {
        return hn::AllTrue(DF(), hn::Or(hn::Not(wanted_), hn::And(active_, inside())));
    }
    /// Lanes that are not wanted stand in the first cell.
    HWY_INLINE void parkOthers() {
        cx_ = hn::IfThenElseZero(maskI(active_), cx_);
        cy_ = hn::IfThenElseZero(maskI(active_), cy_);
    }
    HWY_INLINE bool isActive() const { return !hn::AllFalse(DF(), active_); }
    HWY_INLINE size_t activeLanes() const { return hn::CountTrue(DF(), active_); }

    HWY_INLINE void loadCells(const TerrainCut& cut, const Pools& pools) {
        c_ = firstShape<kInt16>(cut, pools, in_, group_.anchorZ, cx_, cy_);
    }

    HWY_INLINE void lookAtCells() {
        const VF inverse = setF(in_.inverse);
        k_.u = hn::MulAdd(r_.dx, w_, r_.x) * inverse - left_;
        k_.v = hn::MulAdd(r_.dy, w_, r_.y) * inverse - top_;
        const VF turned = r_.bend * w_;
        k_.height = hn::MulAdd(w_, r_.dz + turned, r_.z);
        k_.rise = (r_.dz + turned) + turned;
        const VF alongV = kTriangles ? c_.a : hn::MulAdd(c_.d, k_.u, c_.a);
        const VF ground = hn::MulAdd(k_.v, alongV, hn::MulAdd(c_.b, k_.u, c_.h00));
        const VF twist = hn::Abs(c_.d);
        const VF grade = (hn::Abs(c_.b) + hn::Abs(c_.a)) + (twist + twist);
        // As errorIn(), with a place and a height that are as far as any in the cell.
        const MarchErrors& e = group_.errors;
        const VF farthest = hn::Abs(w_) + setF(group_.span * in_.size);
        const VF shift2 = hn::MulAdd(setF(2.0f * e.shift1 * in_.inverse), farthest,
                                     setF(2.0f * e.shift0 * in_.inverse));
        const VF rounding = hn::MulAdd(setF(kFloatError), hn::Abs(ground), setF(e.height0));
        error_ = hn::MulAdd(grade, shift2 + setF(2.0f * kFloatError),
                            hn::MulAdd(setF(e.height1), farthest, rounding));
        rim_ = setF(4.0f) * shift2;
        if constexpr (kTriangles)
            way_ = overTriangle(c_, k_, r_.bend, ground, error_, rim_ + rim_, g_);
        else
            way_ = overPatch(c_, k_, r_.bend, ground, alongV, error_);
    }

    /// The root at which f falls: f0 / (h + sqrt(h^2 - f0 f2)), h = -slope / 2; f' is -2 sqrt
    /// there.
    HWY_INLINE void solve() {
        h_ = setF(-0.5f) * way_.slope;
        disc_ = hn::NegMulAdd(way_.f0, way_.f2, h_ * h_);
        roots_ = rootsOf(disc_);
        s_ = way_.f0 * inverseNear(h_ + roots_.root);
    }

    /// A lane is told only if it stands above the surface by more than f's error, and is below it
    /// by more than that while still inside its cell: then, f being quadratic, its one way down
    /// lies in between.
    HWY_INLINE void judge() {
        const VF error2 = error_ + error_, half = setF(0.5f) - rim_;
        const VF after = hn::MulAdd(error2, roots_.inverse, s_);  // a little beyond, f is < -error
        const VF u1 = hn::MulAdd(k_.du, after, k_.u), v1 = hn::MulAdd(k_.dv, after, k_.v);
        const MF falls = hn::And(h_ > hn::Zero(DF()), disc_ > setF(1e-3f) * (h_ * h_));
        const MF stays =
            hn::And(offMiddle(u1, v1) < half, (error2 + error2) * hn::Abs(way_.f2) <= disc_);
        if (!steppedIn_) active_ = hn::And(active_, offMiddle(k_.u, k_.v) < half);
        active_ = hn::AndNot(maskF(c_.hole), active_);
        steps_ = steps_ + hn::IfThenElseZero(maskI(active_), setI(1));
        MF told = hn::And(hn::And(active_, way_.lanes), hn::And(falls, stays));
        if constexpr (kTriangles)
            told = hn::And(told, hn::MulAdd(g_.change, after, g_.beyond) < hn::Neg(rim_ + rim_));
        told_ = hn::Or(told_, told);
        active_ = hn::AndNot(told, active_);
        const MF sure = error_ <= setF(2.0f * group_.errors.rounding);
        hitW_ = hn::IfThenElse(told, w_ + s_, hitW_);
        unsure_ = hn::IfThenElse(told, hn::IfThenZeroElse(sure, error_ * roots_.inverse), unsure_);
        hitU_ = hn::IfThenElse(told, hn::MulAdd(k_.du, s_, k_.u), hitU_);
        hitV_ = hn::IfThenElse(told, hn::MulAdd(k_.dv, s_, k_.v), hitV_);
        hitCell_ = select(maskI(told), hn::ShiftLeft<kTileLevels>(cy_) + cx_, hitCell_);
    }

    /// Lanes that clear their cell for certain go on to the next one, not near a corner; the others
    /// are given up.
    HWY_INLINE void advance() {
        const VF one = setF(1.0f), zero = hn::Zero(DF());
        const MF right = k_.du > zero, down = k_.dv > zero;
        const VF wx = borderAt(right, k_.u, k_.du), wy = borderAt(down, k_.v, k_.dv);
        const VF out = hn::Max(hn::Min(wx, wy), zero);
        const MF alongX = wx <= wy;
        const VF along =
            hn::IfThenElse(alongX, hn::MulAdd(k_.dv, out, k_.v), hn::MulAdd(k_.du, out, k_.u));
        const MF between = hn::Abs(along - setF(0.5f)) < setF(0.5f) - rim_;
        const MF clears = kTriangles ? clearsTriangles(out) : clearsPatch(out);
        active_ = hn::And(hn::And(active_, way_.above), hn::And(between, clears));
        const VF stepX = hn::IfThenElseZero(alongX, hn::IfThenElse(right, one, hn::Neg(one)));
        const VF stepY = hn::IfThenZeroElse(alongX, hn::IfThenElse(down, one, hn::Neg(one)));
        w_ = hn::IfThenElse(active_, w_ + out, w_);
        left_ = left_ + stepX;
        top_ = top_ + stepY;
        cx_ = wholeOf(left_) - setI(in_.x);
        cy_ = wholeOf(top_) - setI(in_.y);
        active_ = hn::And(active_, inside());
        parkOthers();
        steppedIn_ = true;
    }

    HWY_INLINE FirstHits hits() const {
        FirstHits hits;
        hits.told = told_;
        hits.left = active_;
        const VF w0 = setF(group_.w0), length = rootsOf(r_.length2).root, hitW = hitW_ + w0;
        hits.t = hitW * length;
        hits.clear = (w_ + w0) * length * setF(0.9999f);
        const VF allowed = hn::Max(setF(1e-3f), hits.t * setF(1e-5f));  // for f' / 2
        hits.placed = unsure_ * length <= allowed;
        hits.u = hitU_;
        hits.v = hitV_;
        hits.forward = hn::MulAdd(hitW, r_.forward, r_.forward0);
        hits.cell = hitCell_;
        hits.steps = steps_;
        return hits;
    }

private:
    HWY_INLINE MF inside() const {
        const auto isBelow = [](VI a, int32_t end) {
            return hn::RebindMask(DF(),
                                  hn::BitCast(DU(), a) < hn::Set(DU(), static_cast<uint32_t>(end)));
        };
        return hn::And(isBelow(cx_, in_.endX), isBelow(cy_, in_.endY));
    }
    /// Where a coordinate leaves the unit square.
    static HWY_INLINE VF borderAt(MF forward, VF at, VF change) {
        const VF least = setF(1e-20f), size = hn::Max(hn::Abs(change), least);
        const VF way = hn::IfThenElse(forward, setF(1.0f) - at, at);
        return way * inverseNear(size);
    }
    /// f is above its error up to `out`: at its end and where it is lowest.
    HWY_INLINE MF clearsPatch(VF out) const {
        const VF f1 = hn::MulAdd(out, hn::MulAdd(way_.f2, out, way_.slope), way_.f0);
        const MF dips = hn::And(h_ > hn::Zero(DF()), way_.f2 * out > h_);
        const MF low = hn::And(dips, hn::MulAdd(error_, way_.f2, disc_) >= hn::Zero(DF()));
        return hn::AndNot(low, f1 > error_);
    }
    HWY_INLINE MF clearsTriangles(VF out) const {
        const VF m1 = hn::MulAdd(g_.dm, out, g_.m0), zero = hn::Zero(DF());
        const MF upper1 = m1 > zero;
        const VF f1 =
            hn::MulAdd(g_.lowerSlope, out, g_.lower0) - hn::IfThenElseZero(upper1, c_.d * m1);
        const MF changes = hn::AndNot(g_.crosses, hn::Xor(upper1, g_.upper));
        return hn::AndNot(changes, f1 > error_);
    }

    const MarchGroup& group_;
    const MarchPlateau& in_;
    const ColumnRays r_;
    VF w_, left_, top_;
    VI cx_, cy_;
    MF wanted_, active_, told_;
    CellShape c_;
    OverCell k_;
    VF error_, rim_;
    FirstWay way_;
    Diagonal g_;
    VF h_, disc_, s_;
    Roots roots_;
    VF hitW_, unsure_, hitU_, hitV_;
    VI hitCell_, steps_;
    bool steppedIn_;
};

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
