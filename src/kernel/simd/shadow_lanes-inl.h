// SPDX-License-Identifier: Apache-2.0
// The walk of shadow rays (docs/traversal.md): the hit cell with its root divided out, then cell by
// cell; at each row of posts the sweep's bounds may decide. A lane is certain or undecided.

#if defined(TERRAY_SHADOW_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_SHADOW_LANES_INL_H_
#undef TERRAY_SHADOW_LANES_INL_H_
#else
#define TERRAY_SHADOW_LANES_INL_H_
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

#include "hwy/highway.h"
#include "kernel/simd/lanes-inl.h"
#include "kernel/simd/shadow_cells-inl.h"
#include "kernel/simd/shadow_lanes.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// A packet of rays, in the sun's axes.
struct SunPacket {
    VI column, row;
    VF u, v, z, dz;
    VF way;  ///< rows from the hit to the lower border of the row
    VI source, bounds;
};

/// Where a ray leaves its cell: how many rows ahead, and whether through the row's border.
struct SunExit {
    VF length;
    MF byRow;
};
HWY_INLINE SunExit exitOf(const SunLanes& s, const SunPacket& r) {
    const VF one = setF(1.0f);
    const VF toRow = one - r.v, toColumn = (one - r.u) * setF(s.inverseShear);
    return {hn::Max(hn::Min(toRow, toColumn), hn::Zero(DF())), toRow <= toColumn};
}

/// What the sweep says of a ray at the next row with bounds.
enum BoundsAhead : int32_t {
    kNotAsked = 0,
    kSaysNothing = 1,
    kCaughtAhead = 2,  ///< if it comes there above the ground, it is dark
};

HWY_INLINE VF errorAfter(const SunLanes& s, VF dz, VF way) {
    const VF perRow = hn::MulAdd(setF(kManyRoundings), hn::Abs(dz), setF(s.errorPerRow));
    return hn::MulAdd(perRow, way + setF(1.0f), setF(s.error));
}

/// Lanes that the bounds ahead have decided.
struct SunAhead {
    MI dark, lit;
};

/// Asks the bounds that are kept at the next row that has some. A ray stays in its strip: without
/// holes on the way there, who is caught there has met the ground before or meets it later. And who
/// is higher than `free`, as from the last such row, is lit, if it surely gains height over ground
/// that faces the sun (`gains`).
HWY_INLINE SunAhead lookAhead(const SunLanes& s, SunPacket& r, MI lanes, MI gains) {
    static_assert(std::has_single_bit(static_cast<unsigned>(kSweepStep)));
    constexpr int kStepBits = std::countr_zero(static_cast<unsigned>(kSweepStep));
    const VI kept = hn::And(r.row, setI(-kSweepStep)) + setI(kSweepStep);
    const VF rows = hn::ConvertTo(DF(), kept - r.row);
    const VF place = hn::MulAdd(setF(s.shear), rows - r.v, hn::ConvertTo(DF(), r.column) + r.u);
    r.bounds = select(lanes, setI(kSaysNothing), r.bounds);
    constexpr float kNearRim = 1e-3f;
    const MI asks = hn::AndNot(
        kept > setI(s.lastRow + 1),
        hn::And(lanes, maskI(place < setF(static_cast<float>(s.lastColumn + 1) - kNearRim))));
    if (hn::AllFalse(DI(), asks)) return {asks, asks};
    const VF shift = setF(s.shear) * hn::ConvertTo(DF(), kept);
    const VF strip = hn::Floor(place - shift);
    const VF first = hn::Floor(hn::Neg(shift)) - setF(2.0f);
    const VI index = (hn::ShiftRight<kStepBits>(kept) - setI(1)) * setI(kSweepStride) +
                     hn::ConvertTo(DI(), strip - first);
    const VI bytes = hn::IfThenElseZero(asks, hn::ShiftLeft<2>(index));
    const VI entry = hn::GatherOffset(DI(), s.entries, bytes);
    const VI up = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), entry)));
    const VI down = hn::And(entry, setI(0xFFFF));
    const VF step = setF(s.codeStep), zero = setF(s.codeZ);
    const VF free = hn::MulAdd(step, hn::ConvertTo(DF(), up), zero);
    const VF caught = hn::MulAdd(step, hn::ConvertTo(DF(), down), zero);
    const VF way = r.way + rows, before = way - setF(kSweepStep);
    const VF bend = setF(s.bend);
    const VF z = hn::MulAdd(way, hn::MulAdd(bend, way, r.dz), r.z);
    const VF z0 = hn::MulAdd(before, hn::MulAdd(bend, before, r.dz), r.z);
    const VF error = errorAfter(s, r.dz, way);
    const MI known = hn::Ne(up, setI(static_cast<int32_t>(kUnknownFree)));
    const MI lit = hn::And(hn::And(asks, gains), hn::And(known, maskI(z0 > free + error)));
    const MI isCaught = hn::And(asks, maskI(z < caught - error));
    if (!s.mayHaveHoles) return {isCaught, lit};
    r.bounds = select(isCaught, setI(kCaughtAhead), r.bounds);
    return {noLanes(), lit};
}

/// How far a ray's clearance over a cell bends below the chord of its ends.
HWY_INLINE VF bendsBelow(const SunLanes& s, const SunCell& c, VF length) {
    const VF second = hn::NegMulAdd(c.twist, setF(s.shear), setF(s.bend));
    return hn::Max(second, hn::Zero(DF())) * (length * length) * setF(0.25f);
}

/// What a step makes of the lanes of a packet: those that are in none of these are lit.
struct SunStep {
    MI dark, undecided, goesOn, ahead, aside;
};

/// What the cell, the bounds and the tile's borders make of lanes that have moved to their cell's
/// border: `passes` are certain to have come there above the ground, `dark` not to.
HWY_INLINE SunStep decide(const SunLanes& s, SunPacket& r, MI lanes, MI byRow, MI passes, MI dark) {
    const VI lastColumn = setI(s.lastColumn), lastRow = setI(s.lastRow);
    // So near to a corner of the tile that the next tile cannot be told.
    const VF nearOne = setF(1.0f - kNearBorder);
    const MI atCorner =
        hn::Or(hn::And(hn::And(byRow, hn::Eq(r.column, lastColumn)), maskI(r.u > nearOne)),
               hn::And(hn::AndNot(byRow, hn::Eq(r.row, lastRow)), maskI(r.v > nearOne)));
    const MI certain = hn::AndNot(atCorner, passes);
    const MI onKept = hn::Eq(hn::And(r.row, setI(kSweepStep - 1)), hn::Zero(DI()));
    const MI reached = hn::And(certain, hn::And(byRow, onKept));
    const MI caught = hn::And(reached, hn::Eq(r.bounds, setI(kCaughtAhead)));
    const MI far = hn::And(reached, maskI(r.way > setF(kMostRows)));
    r.bounds = select(reached, setI(kNotAsked), r.bounds);
    SunStep step;
    step.dark = hn::Or(dark, caught);
    const MI open = hn::AndNot(step.dark, lanes);
    const MI on = hn::AndNot(far, hn::And(open, certain));
    step.undecided = hn::AndNot(on, open);
    step.ahead = hn::And(on, r.row > lastRow);
    step.aside = hn::And(on, r.column > lastColumn);
    step.goesOn = hn::AndNot(hn::Or(step.ahead, step.aside), on);
    return step;
}

/// A row of a packet: from its hits, whose bounds have been asked, or from where rays have come to
/// the next row of posts, or to the border of the tile: through a cell, and the one beside it.
template <bool kInt16, bool kAtHits>
HWY_INLINE SunStep stepShadows(const SunLanes& s, SunPacket& r, MI active) {
    MI lanes = active;
    SunAhead ahead{noLanes(), noLanes()};
    if constexpr (!kAtHits) {
        const MI asks = hn::And(active, hn::Eq(r.bounds, setI(kNotAsked)));
        if (!hn::AllFalse(DI(), asks)) ahead = lookAhead(s, r, asks, active);
        lanes = hn::AndNot(hn::Or(ahead.dark, ahead.lit), active);
        if (hn::AllFalse(DI(), lanes)) return {ahead.dark, lanes, lanes, lanes, lanes};
    }
    const VF one = setF(1.0f), zero = hn::Zero(DF()), shear = setF(s.shear), bend = setF(s.bend);
    const SunPosts p = loadPosts<kInt16>(s, hn::IfThenElseZero(active, r.column),
                                         hn::IfThenElseZero(active, r.row));
    const SunExit exit = exitOf(s, r);
    const VF error = errorAfter(s, r.dz, r.way + one);
    const auto heightAfter = [&](VF v) {
        const VF way = r.way + v;
        return hn::MulAdd(way, hn::MulAdd(bend, way, r.dz), r.z);
    };

    // To the border that is nearer.
    const SunCell c = cellOf(p.a0, p.a1, p.b0, p.b1);
    const VF across = hn::Min(hn::MulAdd(shear, exit.length, r.u), one);
    const VF u1 = hn::IfThenElse(exit.byRow, across, one);
    const VF v1 = hn::IfThenElse(exit.byRow, one, hn::Min(r.v + exit.length, one));
    const VF clear1 = heightAfter(v1) - c.at(u1, v1);
    SunVerdict verdict;
    if constexpr (kAtHits)
        verdict = leaveHit(s, c, r.u, r.v, r.dz, bend, exit.length, error);
    else
        verdict = passPiece(heightAfter(r.v) - c.at(r.u, r.v), clear1,
                            bendsBelow(s, c, exit.length), error);
    const MI outside = hn::Or(r.column > setI(s.lastColumn), r.row > setI(s.lastRow));
    const MI known = hn::AndNot(hn::Or(p.hole, outside), lanes);
    MI dark = hn::And(known, maskI(verdict.dark)), passes = hn::And(known, maskI(verdict.passes));

    // Who has come to a column goes on to the row, but for the tile's border.
    const MI byRow = maskI(exit.byRow);
    const MI beside = hn::AndNot(byRow, r.column < setI(s.lastColumn));
    const SunCell d = cellOf(p.a1, p.a2, p.b1, p.b2);
    const VF rest = one - v1, besideU = shear * rest;
    const VF clear2 = heightAfter(one) - d.at(besideU, one);
    const SunVerdict second = passPiece(clear1, clear2, bendsBelow(s, d, rest), error);
    const MI open = hn::And(beside, passes), knownBeside = hn::AndNot(p.holeBeside, open);
    dark = hn::Or(dark, hn::And(knownBeside, maskI(second.dark)));
    passes = hn::Or(hn::AndNot(beside, passes), hn::And(knownBeside, maskI(second.passes)));

    const MI toRow = hn::Or(byRow, beside);
    const MF toRowF = maskF(toRow);
    const VI oneI = setI(1);
    r.row = select(toRow, r.row + oneI, r.row);
    r.column = select(byRow, r.column, r.column + oneI);
    r.u = hn::IfThenElse(exit.byRow, across, hn::IfThenElseZero(toRowF, besideU));
    r.v = hn::IfThenElse(toRowF, zero, v1);
    r.way = hn::IfThenElse(toRowF, r.way + one, r.way);
    SunStep step = decide(s, r, lanes, toRow, passes, dark);
    step.dark = hn::Or(step.dark, ahead.dark);
    return step;
}

/// Adds the masked lanes of a packet to a block, one behind the other.
HWY_INLINE void append(const SunPacket& r, MI lanes, ShadowBlock& to, size_t at) {
    const MF lanesF = maskF(lanes);
    const auto putI = [&](VI v, int32_t* out) {
        hn::StoreU(hn::Compress(v, lanes), DI(), out + at);
    };
    const auto putF = [&](VF v, float* out) {
        hn::StoreU(hn::Compress(v, lanesF), DF(), out + at);
    };
    putI(r.column, to.column);
    putI(r.row, to.row);
    putF(r.u, to.u);
    putF(r.v, to.v);
    putF(r.z, to.z);
    putF(r.dz, to.dz);
    putF(r.way, to.way);
    putI(r.source, to.source);
    putI(r.bounds, to.bounds);
}
HWY_INLINE void appendSome(const SunPacket& r, MI lanes, ShadowBlock& to) {
    if (hn::AllFalse(DI(), lanes)) return;
    append(r, lanes, to, static_cast<size_t>(to.count));
    to.count += static_cast<int>(hn::CountTrue(DI(), lanes));
}

/// Writes a verdict on the masked lanes.
HWY_INLINE void finish(MI lanes, VI source, ShadowVerdict verdict, uint8_t* verdicts) {
    if (hn::AllFalse(DI(), lanes)) return;
    alignas(64) int32_t from[HWY_LANES(int32_t)];
    const VI packed = hn::Compress(source, lanes);
    hn::Store(packed, DI(), from);
    const size_t count = hn::CountTrue(DI(), lanes);
    for (size_t k = 0; k < count; ++k) verdicts[from[k]] = verdict;
}

HWY_INLINE SunPacket loadPacket(const ShadowBlock& b, size_t p) {
    return {loadI(b.column + p), loadI(b.row + p),    loadF(b.u + p),
            loadF(b.v + p),      loadF(b.z + p),      loadF(b.dz + p),
            loadF(b.way + p),    loadI(b.source + p), loadI(b.bounds + p)};
}

/// A packet of hits.
HWY_INLINE SunPacket packetOf(const SunLanes& s, const SunAsks& asks, size_t p, int first) {
    const VI cell = loadI(asks.cell + p);
    SunPacket r;
    r.column = hn::And(cell, setI(kSlotCells - 1));
    r.row = hn::ShiftRight<kTileLevels>(cell);
    r.u = loadF(asks.u + p);
    r.v = loadF(asks.v + p);
    turnToSun(s, r.column, r.row, r.u, r.v);
    r.z = loadF(asks.z + p) - setF(s.anchorZ);
    r.dz = hn::MulAdd(
        setF(s.risePerRow), hn::ConvertTo(DF(), r.row) + r.v,
        hn::MulAdd(setF(s.risePerColumn), hn::ConvertTo(DF(), r.column) + r.u, setF(s.rise)));
    r.way = hn::Neg(r.v);
    r.source = hn::Iota(DI(), first + static_cast<int>(p));
    r.bounds = setI(kNotAsked);
    return r;
}

int startAll(const SunLanes& s, uint32_t slot, const SunAsks& asks, int first, ShadowBlock& hits,
             uint8_t* verdicts) {
    const hn::Rebind<uint8_t, DI> bytes;
    const size_t lanes = hn::Lanes(DI());
    size_t rays = 0;
    for (size_t p = 0; p < kSunAsks; p += lanes) {
        const VI tile = loadI(reinterpret_cast<const int32_t*>(asks.tile) + p);
        const MI active = hn::Eq(tile, setI(static_cast<int32_t>(slot)));
        if (hn::AllFalse(DI(), active)) continue;
        rays += hn::CountTrue(DI(), active);
        SunPacket r = packetOf(s, asks, p, first);
        const MI rim = hn::And(active, standsAtRim(r.column, r.row, r.u, r.v));
        const MI inside = hn::AndNot(rim, active);
        const VF gain = exitOf(s, r).length * (r.dz * setF(kGainOnFacing));
        const VF error = errorAfter(s, r.dz, setF(0.0f));
        const SunAhead ahead = lookAhead(s, r, inside, maskI(gain > error + error));
        const VI verdict = hn::Or(hn::IfThenElseZero(ahead.dark, setI(kShadowDark)),
                                  hn::IfThenElseZero(rim, setI(kShadowUndecided)));
        uint8_t* out = verdicts + static_cast<size_t>(first) + p;
        hn::StoreU(hn::Or(hn::LoadU(bytes, out), hn::DemoteTo(bytes, verdict)), bytes, out);
        appendSome(r, hn::AndNot(hn::Or(ahead.dark, ahead.lit), inside), hits);
    }
    return static_cast<int>(rays);
}

template <bool kInt16>
uint64_t leaveAll(const SunLanes& s, bool all, ShadowBlock& hits, ShadowBlock& block,
                  ShadowLeaving& leaving, uint8_t* verdicts) {
    const size_t lanes = hn::Lanes(DI()), count = static_cast<size_t>(hits.count);
    const size_t end = all ? count : count / lanes * lanes;
    for (size_t p = 0; p < end; p += lanes) {
        SunPacket r = loadPacket(hits, p);
        const SunStep step = stepShadows<kInt16, true>(s, r, hn::FirstN(DI(), count - p));
        finish(step.dark, r.source, kShadowDark, verdicts);
        finish(step.undecided, r.source, kShadowUndecided, verdicts);
        appendSome(r, step.goesOn, block);
        appendSome(r, step.ahead, leaving.ahead);
        appendSome(r, step.aside, leaving.aside);
    }
    if (end < count && end > 0)
        append(loadPacket(hits, end), hn::FirstN(DI(), count - end), hits, 0);
    hits.count = static_cast<int>(count - std::min(end, count));
    return std::min(end, count);
}

template <bool kInt16>
uint64_t walkAll(const SunLanes& s, int rest, ShadowBlock& b, ShadowLeaving& leaving,
                 uint8_t* verdicts) {
    const size_t lanes = hn::Lanes(DI());
    auto left = static_cast<size_t>(b.count);
    uint64_t cells = 0;
    while (left > static_cast<size_t>(rest)) {
        cells += left;
        size_t on = 0;
        for (size_t p = 0; p < left; p += lanes) {
            SunPacket r = loadPacket(b, p);
            const SunStep step = stepShadows<kInt16, false>(s, r, hn::FirstN(DI(), left - p));
            finish(step.dark, r.source, kShadowDark, verdicts);
            finish(step.undecided, r.source, kShadowUndecided, verdicts);
            appendSome(r, step.ahead, leaving.ahead);
            appendSome(r, step.aside, leaving.aside);
            // Never ahead of the packets that are still to be read.
            append(r, step.goesOn, b, on);
            on += hn::CountTrue(DI(), step.goesOn);
        }
        left = on;
    }
    b.count = static_cast<int>(left);
    return cells;
}

SunLanes lanesOf(const TerrainCut& cut, const SunSweep& sweep, const SweptTile& tile) {
    const SunAxes& axes = sweep.axes();
    const auto shear = static_cast<float>(axes.shear);
    return {static_cast<const int32_t*>(tile.posts),
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
            tile.errorPerRow,
            tile.rise,
            tile.risePerColumn,
            tile.risePerRow,
            tile.columns - 1,
            tile.rows - 1,
            axes.transposed,
            axes.mirroredX,
            axes.mirroredY,
            cut.hasHoles != 0};
}

int startShadowLanes(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot,
                     const SunAsks& asks, int first, ShadowBlock& hits, uint8_t* verdicts) {
    return startAll(lanesOf(cut, sweep, sweep.tile(slot)), slot, asks, first, hits, verdicts);
}

uint64_t leaveShadowLanes(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, bool all,
                          ShadowBlock& hits, ShadowBlock& block, ShadowLeaving& leaving,
                          uint8_t* verdicts) {
    const SunLanes s = lanesOf(cut, sweep, sweep.tile(slot));
    const auto leave = cut.format == 0 ? leaveAll<true> : leaveAll<false>;
    return leave(s, all, hits, block, leaving, verdicts);
}

uint64_t walkShadowLanes(const TerrainCut& cut, const SunSweep& sweep, uint32_t slot, int rest,
                         ShadowBlock& block, ShadowLeaving& leaving, uint8_t* verdicts) {
    const SunLanes s = lanesOf(cut, sweep, sweep.tile(slot));
    const auto walk = cut.format == 0 ? walkAll<true> : walkAll<false>;
    return walk(s, rest, block, leaving, verdicts);
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
