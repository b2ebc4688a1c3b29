// SPDX-License-Identifier: Apache-2.0
// The ground under shadow rays: posts around their cells in the sun's axes, and what a piece of the
// way makes of a ray.

#if defined(TERRAY_SHADOW_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_SHADOW_CELLS_INL_H_
#undef TERRAY_SHADOW_CELLS_INL_H_
#else
#define TERRAY_SHADOW_CELLS_INL_H_
#endif

#include <utility>

#include "hwy/highway.h"
#include "kernel/simd/lanes-inl.h"
#include "kernel/simd/shadow_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// What all lanes of a block share.
struct SunLanes {
    const int32_t* posts;
    const int32_t* entries;
    float anchorZ, postsZ, postsStep, codeZ, codeStep;
    float shear, inverseShear, bend, error, errorPerRow;
    float rise, risePerColumn, risePerRow;
    int32_t lastColumn, lastRow;
    bool transposed, mirroredX, mirroredY, mayHaveHoles;
};

/// Rows of a walk, after which a ray is cast; bounds the error of a lane's place: less than 2.5e-7
/// cells a step, at most two steps a row.
constexpr float kMostRows = 48.0f;
/// A place this near to a border may lie beyond it, in cells.
constexpr float kNearBorder = 3e-5f;
/// Relative error of a float expression of some 16 roundings.
constexpr float kManyRoundings = 1e-6f;

/// The posts around a lane's cell and the one beside it, in the sun's axes: columns 0, 1, 2 of its
/// row (a) and of the next (b). Beside the last column of a tile stands anything.
struct SunPosts {
    VF a0, a1, a2, b0, b1, b2;
    MI hole, holeBeside;
};

/// Codes of four posts from places of the pool on: two each.
struct CodeRow {
    VI low, high;
};
HWY_INLINE CodeRow gatherRow(const int32_t* posts, VI bytes) {
#if HWY_TARGET == HWY_SCALAR
    return {hn::GatherOffset(DI(), posts, bytes), hn::GatherOffset(DI(), posts, bytes + setI(4))};
#else
    // Half as many words: gathers take a time per word.
    const hn::RepartitionToWide<DI> wide;
    const hn::Half<DI> half;
    const auto* pairs = reinterpret_cast<const int64_t*>(posts);
    const auto lower =
        hn::GatherOffset(wide, pairs, hn::PromoteTo(wide, hn::LowerHalf(half, bytes)));
    const auto upper =
        hn::GatherOffset(wide, pairs, hn::PromoteTo(wide, hn::UpperHalf(half, bytes)));
    const VI x = hn::BitCast(DI(), lower), y = hn::BitCast(DI(), upper);
    return {hn::ConcatEven(DI(), y, x), hn::ConcatOdd(DI(), y, x)};
#endif
}

HWY_INLINE VI highHalf(VI v) { return hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), v))); }
HWY_INLINE VI lowHalf(VI v) { return hn::And(v, setI(0xFFFF)); }

/// The six codes, as SunPosts has them.
struct SunCodes {
    VI a0, a1, a2, b0, b1, b2;
};

/// Rows of the sun are rows of posts.
HWY_INLINE SunCodes codesAlong(const SunLanes& s, VI x, VI y) {
    const VI zero = hn::Zero(DI()), one = setI(1);
    // Two posts before the first of a row do not exist.
    const VI first = s.mirroredX ? hn::Max(x - one, zero) : x;
    const VI bytes = hn::ShiftLeft<1>(y * setI(kPostStride) + first);
    const CodeRow upper = gatherRow(s.posts, bytes);
    const CodeRow lower = gatherRow(s.posts, bytes + setI(2 * kPostStride));
    const auto triple = [&](const CodeRow& q, VI& c0, VI& c1, VI& c2) {
        c0 = lowHalf(q.low), c1 = highHalf(q.low), c2 = lowHalf(q.high);
        if (!s.mirroredX) return;
        std::swap(c0, c2);
        const MI shifted = hn::Eq(x, zero);
        c0 = select(shifted, c1, c0);
        c1 = select(shifted, c2, c1);
    };
    SunCodes c;
    triple(upper, c.a0, c.a1, c.a2);
    triple(lower, c.b0, c.b1, c.b2);
    if (s.mirroredY) {
        std::swap(c.a0, c.b0);
        std::swap(c.a1, c.b1);
        std::swap(c.a2, c.b2);
    }
    return c;
}

/// Rows of the sun are columns of posts.
HWY_INLINE SunCodes codesAcross(const SunLanes& s, VI x, VI y) {
    const VI stride = setI(kPostStride), zero = hn::Zero(DI());
    const VI near = s.mirroredY ? y + setI(1) : y, far = s.mirroredY ? y : y + setI(1);
    const VI beside =
        s.mirroredY ? hn::Max(y - setI(1), zero) : hn::Min(y + setI(2), setI(kSlotCells));
    const auto pairAt = [&](VI row) {
        return hn::GatherOffset(DI(), s.posts, hn::ShiftLeft<1>(row * stride + x));
    };
    const VI p0 = pairAt(near), p1 = pairAt(far), p2 = pairAt(beside);
    if (s.mirroredX)
        return {highHalf(p0), highHalf(p1), highHalf(p2), lowHalf(p0), lowHalf(p1), lowHalf(p2)};
    return {lowHalf(p0), lowHalf(p1), lowHalf(p2), highHalf(p0), highHalf(p1), highHalf(p2)};
}

HWY_INLINE SunPosts decode(const SunLanes& s, const SunCodes& c) {
    const VF step = setF(s.postsStep), zero = setF(s.postsZ);
    const auto z = [&](VI code) { return hn::MulAdd(step, hn::ConvertTo(DF(), code), zero); };
    SunPosts p{z(c.a0), z(c.a1), z(c.a2), z(c.b0), z(c.b1), z(c.b2), noLanes(), noLanes()};
    if (!s.mayHaveHoles) return p;
    const VI hole = setI(0xFFFF), middle = hn::Max(c.a1, c.b1);
    p.hole = hn::Eq(hn::Max(middle, hn::Max(c.a0, c.b0)), hole);
    p.holeBeside = hn::Eq(hn::Max(middle, hn::Max(c.a2, c.b2)), hole);
    return p;
}

HWY_INLINE SunPosts gatherFloats(const SunLanes& s, VI x, VI y) {
    const auto* posts = reinterpret_cast<const float*>(s.posts);
    const VF anchor = setF(s.anchorZ);
    // Places of post (column, row) of the three columns and two rows.
    const auto at = [&](int column, int row) {
        const bool flipColumn = s.transposed ? s.mirroredY : s.mirroredX;
        const bool flipRow = s.transposed ? s.mirroredX : s.mirroredY;
        const VI c = setI(flipColumn ? 1 - column : column), r = setI(flipRow ? 1 - row : row);
        const VI last = setI(kSlotCells), zero = hn::Zero(DI());
        const VI px = hn::Min(hn::Max(x + (s.transposed ? r : c), zero), last);
        const VI py = hn::Min(hn::Max(y + (s.transposed ? c : r), zero), last);
        const VI bytes = hn::ShiftLeft<2>(py * setI(kPostStride) + px);
        return hn::GatherOffset(DF(), posts, bytes) - anchor;
    };
    SunPosts p{at(0, 0), at(1, 0), at(2, 0), at(0, 1), at(1, 1), at(2, 1), noLanes(), noLanes()};
    const VF sum = p.a1 + p.b1, near = sum + (p.a0 + p.b0), far = sum + (p.a2 + p.b2);
    p.hole = hn::Not(maskI(near == near));
    p.holeBeside = hn::Not(maskI(far == far));
    return p;
}

template <bool kInt16>
HWY_INLINE SunPosts loadPosts(const SunLanes& s, VI column, VI row) {
    const VI last = setI(kSlotCells - 1);
    VI x = s.transposed ? row : column, y = s.transposed ? column : row;
    if (s.mirroredX) x = last - x;
    if (s.mirroredY) y = last - y;
    if constexpr (kInt16)
        return decode(s, s.transposed ? codesAcross(s, x, y) : codesAlong(s, x, y));
    else
        return gatherFloats(s, x, y);
}

/// Heights in a cell: h00 + across u + v (ahead + twist u).
struct SunCell {
    VF h00, acrossColumns, acrossRows, twist;
    VF at(VF u, VF v) const {
        return hn::MulAdd(v, hn::MulAdd(twist, u, acrossRows), hn::MulAdd(acrossColumns, u, h00));
    }
};
HWY_INLINE SunCell cellOf(VF a0, VF a1, VF b0, VF b1) {
    const VF across = a1 - a0;
    return {a0, across, b0 - a0, (b1 - b0) - across};
}

/// Puts a hit's place into the sun's axes.
HWY_INLINE void turnToSun(const SunLanes& s, VI& column, VI& row, VF& u, VF& v) {
    const VI last = setI(kSlotCells - 1);
    const VF one = setF(1.0f);
    if (s.mirroredX) {
        column = last - column;
        u = one - u;
    }
    if (s.mirroredY) {
        row = last - row;
        v = one - v;
    }
    if (s.transposed) {
        std::swap(column, row);
        std::swap(u, v);
    }
}

/// dark, passes: certain.
struct SunVerdict {
    MF dark, passes;
};

/// Hits at the rim of the tile that a ray comes in through, or along.
HWY_INLINE MI standsAtRim(VI column, VI row, VF u, VF v) {
    const VF near = setF(kNearBorder);
    return hn::Or(hn::Or(hn::And(hn::Eq(column, hn::Zero(DI())), maskI(u < near)),
                         hn::And(hn::Eq(row, hn::Zero(DI())), maskI(v < near))),
                  hn::And(hn::Eq(column, setI(kSlotCells - 1)), maskI(u > setF(1.0f) - near)));
}

/// The hit cell: f(t) / t = f1 + f2 t must keep its sign. Places at a border in the ray's way are
/// left to others.
HWY_INLINE SunVerdict leaveHit(const SunLanes& s, const SunCell& c, VF u, VF v, VF dz, VF bend,
                               VF length, VF error) {
    const VF shear = setF(s.shear), near = setF(kNearBorder);
    const VF f1 =
        dz - ((c.acrossColumns * shear + c.acrossRows) + c.twist * hn::MulAdd(v, shear, u));
    const VF f2 = bend - c.twist * shear;
    const VF end = hn::MulAdd(f2, length, f1);
    const VF size =
        (hn::Abs(dz) + hn::Abs(c.acrossColumns)) + (hn::Abs(c.acrossRows) + hn::Abs(c.twist));
    const VF unsure = hn::MulAdd(size, setF(2e-5f), error + error);
    const VF least = hn::Min(f1, end);
    const MF clear = hn::AndNot(length < near, least == least);
    return {hn::And(clear, least < hn::Neg(unsure)), hn::And(clear, least > unsure)};
}

/// A piece of a ray's way that came from above: its clearance at both ends, and how far that bends
/// below their chord in the middle.
HWY_INLINE SunVerdict passPiece(VF from, VF to, VF bends, VF error) {
    const VF difference = to - from, four = setF(4.0f);
    // NaN or infinite where it is straight. A little beside the turn it is hardly higher: two
    // roundings of a reciprocal will do.
    const VF wide = setF(16.0f) * bends, rough = hn::ApproximateReciprocal(wide);
    const VF perWide = rough * hn::NegMulAdd(wide, rough, setF(2.0f));
    const VF middle = hn::MulAdd(setF(0.5f), from + to, hn::Neg(bends));
    const VF turn = hn::NegMulAdd(difference * difference, perWide, middle);
    const MF turns = bends * four > hn::Abs(difference);
    const VF least = hn::IfThenElse(turns, turn, hn::Min(from, to));
    return {least<hn::Neg(error), least> error};
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
