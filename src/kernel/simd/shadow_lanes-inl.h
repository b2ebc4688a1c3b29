// SPDX-License-Identifier: Apache-2.0
// The walk of shadow rays (docs/traversal.md): the hit cell with its root divided out, then cell by
// cell; at each row of posts the sweep's bounds may decide. A lane is certain or undecided.

#if defined(TERRAY_SHADOW_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_SHADOW_LANES_INL_H_
#undef TERRAY_SHADOW_LANES_INL_H_
#else
#define TERRAY_SHADOW_LANES_INL_H_
#endif

#include <bit>
#include <cstddef>
#include <utility>

#include "hwy/highway.h"
#include "kernel/simd/lanes-inl.h"
#include "kernel/simd/shadow_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// What all lanes of a block share.
struct SunLanes {
    ShadowBlock& b;
    const int32_t* posts;
    const int32_t* entries;
    float anchorZ, postsZ, postsStep, codeZ, codeStep;
    float shear, inverseShear, bend, error;
    int32_t lastColumn, lastRow;
    bool transposed, mirroredX, mirroredY;
};

/// Steps of a walk in a tile, after which a ray is cast; bounds the error of a lane's place.
constexpr int kMostSteps = 16;
/// A place this near to a border may lie beyond it, in cells.
constexpr float kNearBorder = 1e-5f;
/// Relative error of a float expression of some 16 roundings.
constexpr float kManyRoundings = 1e-6f;

/// A lane's cell in the sun's axes: heights against the ray, and the way to its exit.
struct SunCell {
    VF h00, acrossColumns, acrossRows, twist;
    MI hole;
};

template <bool kInt16>
HWY_INLINE SunCell loadCell(const SunLanes& s, VI column, VI row) {
    const VI last = setI(kSlotCells - 1);
    VI x = s.transposed ? row : column, y = s.transposed ? column : row;
    if (s.mirroredX) x = last - x;
    if (s.mirroredY) y = last - y;
    const VI index = y * setI(kPostStride) + x;
    VF a, b, c, d;  // (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)
    MI hole;
    if constexpr (kInt16) {
        const VI bytes = hn::ShiftLeft<1>(index);
        const VI upper = hn::GatherOffset(DI(), s.posts, bytes);
        const VI lower = hn::GatherOffset(DI(), s.posts, bytes + setI(2 * kPostStride));
        const VI low = setI(0xFFFF);
        const auto high = [](VI v) {
            return hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), v)));
        };
        const VI q00 = hn::And(upper, low), q01 = hn::And(lower, low);
        const VI q10 = high(upper), q11 = high(lower);
        hole = hn::Eq(hn::Max(hn::Max(q00, q10), hn::Max(q01, q11)), low);
        const VF step = setF(s.postsStep), zero = setF(s.postsZ);
        a = hn::MulAdd(step, hn::ConvertTo(DF(), q00), zero);
        b = hn::MulAdd(step, hn::ConvertTo(DF(), q10), zero);
        c = hn::MulAdd(step, hn::ConvertTo(DF(), q01), zero);
        d = hn::MulAdd(step, hn::ConvertTo(DF(), q11), zero);
    } else {
        const VI bytes = hn::ShiftLeft<2>(index);
        const float* posts = reinterpret_cast<const float*>(s.posts);
        const VF anchor = setF(s.anchorZ);
        a = hn::GatherOffset(DF(), posts, bytes) - anchor;
        b = hn::GatherOffset(DF(), posts, bytes + setI(4)) - anchor;
        c = hn::GatherOffset(DF(), posts, bytes + setI(4 * kPostStride)) - anchor;
        d = hn::GatherOffset(DF(), posts, bytes + setI(4 * kPostStride + 4)) - anchor;
        const VF sum = (a + b) + (c + d);
        hole = hn::Not(maskI(sum == sum));
    }
    if (s.mirroredX) {
        std::swap(a, b);
        std::swap(c, d);
    }
    if (s.mirroredY) {
        std::swap(a, c);
        std::swap(b, d);
    }
    if (s.transposed) std::swap(b, c);
    const VF across = b - a;
    return {a, across, c - a, (d - c) - across, hole};
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

/// The hit cell: f(t) / t = f1 + f2 t must keep its sign. Places at a border in the ray's way, or
/// at the tile's rim, are left to others.
HWY_INLINE SunVerdict leaveHit(const SunLanes& s, const SunCell& c, VI column, VI row, VF u, VF v,
                               VF dz, VF bend, VF length, VF error) {
    const VF shear = setF(s.shear), near = setF(kNearBorder);
    const VF f1 =
        dz - ((c.acrossColumns * shear + c.acrossRows) + c.twist * hn::MulAdd(v, shear, u));
    const VF f2 = bend - c.twist * shear;
    const VF end = hn::MulAdd(f2, length, f1);
    const VF size =
        (hn::Abs(dz) + hn::Abs(c.acrossColumns)) + (hn::Abs(c.acrossRows) + hn::Abs(c.twist));
    const VF unsure = hn::MulAdd(size, setF(2e-5f), error + error);
    const VF least = hn::Min(f1, end);
    const MF atRim =
        hn::Or(hn::Or(hn::And(maskF(hn::Eq(column, hn::Zero(DI()))), u < near),
                      hn::And(maskF(hn::Eq(row, hn::Zero(DI()))), v < near)),
               hn::And(maskF(hn::Eq(column, setI(kSlotCells - 1))), u > setF(1.0f) - near));
    const MF clear = hn::AndNot(hn::Or(length < near, atRim), least == least);
    return {hn::And(clear, least < hn::Neg(unsure)), hn::And(clear, least > unsure)};
}

/// Any later cell: the ray came from above.
HWY_INLINE SunVerdict passCell(const SunLanes& s, const SunCell& c, VF u, VF v, VF z, VF slope,
                               VF bend, VF length, VF error) {
    const VF shear = setF(s.shear), zero = hn::Zero(DF());
    const VF f0 = z - hn::MulAdd(v, hn::MulAdd(c.twist, u, c.acrossRows),
                                 hn::MulAdd(c.acrossColumns, u, c.h00));
    const VF f1 =
        slope - ((c.acrossColumns * shear + c.acrossRows) + c.twist * hn::MulAdd(v, shear, u));
    const VF f2 = bend - c.twist * shear;
    const auto at = [&](VF t) { return hn::MulAdd(t, hn::MulAdd(f2, t, f1), f0); };
    const VF end = at(length);
    const VF turn = f1 / (setF(-2.0f) * f2);  // NaN or infinite where f is straight
    const VF inside = hn::Min(hn::Max(turn, zero), length);
    const VF extreme = hn::IfThenElse(turn == turn, at(inside), end);
    const VF least = hn::Min(hn::Min(f0, end), extreme);
    return {least<hn::Neg(error), least> error};
}

/// The bounds at the crossing of a row.
HWY_INLINE SunVerdict lookUp(const SunLanes& s, VI column, VI row, VF u, VF z, VF error, MI lanes) {
    const VF r = hn::ConvertTo(DF(), row);
    const VF shift = setF(s.shear) * r;
    const VF strip = hn::Floor((hn::ConvertTo(DF(), column) + u) - shift);
    const VF first = hn::Floor(hn::Neg(shift)) - setF(2.0f);
    constexpr int kStepBits = std::countr_zero(static_cast<unsigned>(kSweepStep));
    const VI index = (hn::ShiftRight<kStepBits>(row) - setI(1)) * setI(kSweepStride) +
                     hn::ConvertTo(DI(), strip - first);
    const VI bytes = hn::IfThenElseZero(lanes, hn::ShiftLeft<2>(index));
    const VI entry = hn::GatherOffset(DI(), s.entries, bytes);
    const VI up = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), entry)));
    const VI down = hn::And(entry, setI(0xFFFF));
    const VF step = setF(s.codeStep), zero = setF(s.codeZ);
    const VF free = hn::MulAdd(step, hn::ConvertTo(DF(), up), zero);
    const VF caught = hn::MulAdd(step, hn::ConvertTo(DF(), down), zero);
    const MF known = maskF(hn::And(lanes, hn::Ne(up, setI(0xFFFF))));
    return {hn::And(maskF(lanes), z < caught - error), hn::And(known, z > free + error)};
}

/// What a step makes of the lanes of a packet.
struct SunStep {
    VI result, column, row;
    VF u, v, crossed, start;
};

/// What the sun's bounds and the tile's borders make of lanes that have moved to their cell's
/// border: `passes` are certain to have come there above the ground, `dark` not to.
HWY_INLINE VI decide(const SunLanes& s, const SunStep& now, MI active, MI byRow, MI passes, MI dark,
                     VF z0, VF dz, VF error) {
    const VI lastColumn = setI(s.lastColumn), lastRow = setI(s.lastRow);
    // So near to a corner of the tile that the next tile cannot be told.
    const VF nearOne = setF(1.0f - kNearBorder);
    const MI atCorner =
        hn::Or(hn::And(hn::And(byRow, hn::Eq(now.column, lastColumn)), maskI(now.u > nearOne)),
               hn::And(hn::AndNot(byRow, hn::Eq(now.row, lastRow)), maskI(now.v > nearOne)));
    const MI certain = hn::AndNot(atCorner, passes);
    MI asks = hn::And(active, hn::And(certain, byRow));
    if constexpr (kSweepStep > 1)
        asks = hn::And(asks, hn::Eq(hn::And(now.row, setI(kSweepStep - 1)), hn::Zero(DI())));
    MI lit = noLanes();
    if (!hn::AllFalse(DI(), asks)) {
        const VF way = now.crossed - now.start;
        const VF z = hn::MulAdd(way, hn::MulAdd(setF(s.bend), way, dz), z0);
        const SunVerdict known = lookUp(s, now.column, now.row, now.u, z, error, asks);
        dark = hn::Or(dark, maskI(known.dark));
        lit = maskI(known.passes);
    }
    VI result = select(now.row > lastRow, setI(kShadowAhead), setI(kShadowGoesOn));
    result = select(now.column > lastColumn, setI(kShadowAside), result);
    result = select(certain, result, setI(kShadowUndecided));
    result = select(lit, setI(kShadowLit), result);
    return select(dark, setI(kShadowDark), result);
}

/// One cell of a packet.
template <bool kInt16, bool kFirst>
HWY_INLINE SunStep stepShadows(const SunLanes& s, size_t p, MI active) {
    const ShadowBlock& b = s.b;
    const VF one = setF(1.0f), zero = hn::Zero(DF());
    VI column = hn::IfThenElseZero(active, loadI(b.column + p));
    VI row = hn::IfThenElseZero(active, loadI(b.row + p));
    VF u = loadF(b.u + p), v = loadF(b.v + p), start = loadF(b.start + p);
    if constexpr (kFirst) {
        turnToSun(s, column, row, u, v);
        start = v;
    }
    const SunCell c = loadCell<kInt16>(s, column, row);
    const VF dz = loadF(b.dz + p), z0 = loadF(b.z + p);
    const VF bend = setF(s.bend);
    const VF crossed = loadF(b.crossed + p);
    const VF toRow = one - v, toColumn = (one - u) * setF(s.inverseShear);
    const MI byRow = maskI(toRow <= toColumn);
    const VF length = hn::Max(hn::Min(toRow, toColumn), zero);
    const VF way = crossed + (v - start);
    const VF error = hn::MulAdd(setF(kManyRoundings) * hn::Abs(dz), way + one, setF(s.error));
    SunVerdict inCell;
    if constexpr (kFirst) {
        inCell = leaveHit(s, c, column, row, u, v, dz, bend, length, error);
    } else {
        const VF z = hn::MulAdd(way, hn::MulAdd(bend, way, dz), z0);
        const VF slope = hn::MulAdd(bend + bend, way, dz);
        inCell = passCell(s, c, u, v, z, slope, bend, length, error);
    }
    const VI oneI = setI(1);
    const MI outside = hn::Or(column > setI(s.lastColumn), row > setI(s.lastRow));
    const MI unclear = hn::Or(c.hole, outside);
    const MI dark = hn::AndNot(unclear, maskI(inCell.dark));
    const MI passes = hn::AndNot(unclear, maskI(inCell.passes));

    // On to the border that is nearer.
    const VF across = hn::Min(hn::MulAdd(setF(s.shear), length, u), one);
    SunStep now;
    now.row = select(byRow, row + oneI, row);
    now.column = select(byRow, column, column + oneI);
    now.u = hn::IfThenElse(maskF(byRow), across, zero);
    now.v = hn::IfThenElse(maskF(byRow), zero, hn::Min(v + length, one));
    now.crossed = hn::IfThenElse(maskF(byRow), crossed + one, crossed);
    now.start = start;
    now.result = decide(s, now, active, byRow, passes, dark, z0, dz, error);
    return now;
}

/// Writes the masked lanes of a packet to a block, one behind the other.
HWY_INLINE void pack(const ShadowBlock& from, size_t p, const SunStep& step, VI source, MI lanes,
                     ShadowBlock& to, size_t at) {
    const MF lanesF = maskF(lanes);
    const auto putI = [&](VI v, int32_t* out) {
        hn::StoreU(hn::Compress(v, lanes), DI(), out + at);
    };
    const auto putF = [&](VF v, float* out) {
        hn::StoreU(hn::Compress(v, lanesF), DF(), out + at);
    };
    const VF z = loadF(from.z + p), dz = loadF(from.dz + p);
    putI(step.column, to.column);
    putI(step.row, to.row);
    putF(step.u, to.u);
    putF(step.v, to.v);
    putF(z, to.z);
    putF(dz, to.dz);
    putF(step.crossed, to.crossed);
    putF(step.start, to.start);
    putI(source, to.source);
    putI(step.result, to.result);
}

template <bool kInt16>
uint64_t walkAll(const SunLanes& s, int count, bool atHits, int32_t* results, ShadowBlock& leaving,
                 int& leavingCount) {
    constexpr size_t kLanes = HWY_LANES(float) < 16 ? HWY_LANES(float) : 16;
    ShadowBlock& b = s.b;
    auto left = static_cast<size_t>(count);
    uint64_t cells = 0;
    for (int step = 0; left != 0; ++step) {
        cells += left;
        size_t on = 0;
        for (size_t p = 0; p < left; p += kLanes) {
            const MI active = hn::FirstN(DI(), left - p);
            const SunStep now = step == 0 && atHits ? stepShadows<kInt16, true>(s, p, active)
                                                    : stepShadows<kInt16, false>(s, p, active);
            const VI source = loadI(b.source + p);
            alignas(64) int32_t result[16], from[16];
            hn::Store(now.result, DI(), result);
            hn::Store(source, DI(), from);
            const size_t lanes = left - p < kLanes ? left - p : kLanes;
            for (size_t k = 0; k < lanes; ++k) results[from[k]] = result[k];
            const MI goOn = hn::And(active, hn::Eq(now.result, hn::Zero(DI())));
            const MI leave = hn::And(active, now.result > setI(kShadowUndecided));
            if (!hn::AllFalse(DI(), leave)) {
                pack(b, p, now, source, leave, leaving, static_cast<size_t>(leavingCount));
                leavingCount += static_cast<int>(hn::CountTrue(DI(), leave));
            }
            // Never ahead of the packets that are still to be read.
            pack(b, p, now, source, goOn, b, on);
            on += hn::CountTrue(DI(), goOn);
        }
        left = on;
        if (step + 1 < kMostSteps) continue;
        for (size_t k = 0; k < left; ++k) results[b.source[k]] = kShadowUndecided;
        break;
    }
    return cells;
}

uint64_t walkShadowLanes(const TerrainCut& cut, const SunSweep& sweep, const SweptTile& tile,
                         ShadowBlock& b, int count, bool atHits, int32_t* results,
                         ShadowBlock& leaving, int& leavingCount) {
    const SunAxes& axes = sweep.axes();
    const auto shear = static_cast<float>(axes.shear);
    const SunLanes s{b,
                     static_cast<const int32_t*>(tile.posts),
                     reinterpret_cast<const int32_t*>(tile.entries),
                     sweep.anchorZ(),
                     tile.postsZ,
                     tile.postsStep,
                     sweep.codeZ(),
                     sweep.codeStep(),
                     shear,
                     shear > 1e-20f ? 1.0f / shear : 1e20f,
                     static_cast<float>(sweep.sun().bend) * tile.perRow * tile.perRow,
                     tile.error,
                     tile.columns - 1,
                     tile.rows - 1,
                     axes.transposed,
                     axes.mirroredX,
                     axes.mirroredY};
    const auto walk = cut.format == 0 ? walkAll<true> : walkAll<false>;
    return walk(s, count, atHits, results, leaving, leavingCount);
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
