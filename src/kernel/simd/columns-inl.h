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
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "hwy/highway.h"
#include "kernel/columns.h"
#include "kernel/simd/columns.h"
#include "kernel/simd/march_cell-inl.h"
#include "kernel/simd/march_first-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// Cells that a packet walks before its last few lanes, or all, are left to the tracer.
constexpr int kFewCells = 3, kMostCells = 16;
constexpr size_t kFewLanes = 3;

/// Ends the lanes that have hit their cell (x, y).
HWY_INLINE void storeHits(const MarchGroup& group, const ColumnRays& r, const MarchCell& k,
                          const MarchErrors& e, MarchLanes& m, size_t p, VI x, VI y, VI mip,
                          MI hits) {
    if (hn::AllFalse(DI(), hits)) return;
    const MI fixed = fixHits(group, r, k, m, p, hits, e.rounding);
    const VI cellMask = setI(kSlotCells - 1);
    const VI cx = hn::And(shiftRight(x, mip), cellMask);
    const VI cy = hn::And(shiftRight(y, mip), cellMask);
    storeI(hits, hn::ShiftLeft<kTileLevels>(cy) + cx, m.cell + p);
    storeI(hits, select(fixed, setI(kMarchHit), setI(kMarchCell)), m.result + p);
}

/// Lanes that have nothing before them from w on: beside or beyond the terrain's rectangle, or
/// above or below all ground wherever they are in it.
HWY_INLINE MI isPast(const TerrainCut& cut, const MarchGroup& group, const MarchErrors& e,
                     const ColumnRays& r, VF w) {
    // One cell around covers the errors of places.
    const VF left = setF(static_cast<float>(-1 - group.anchorX)) - r.x;
    const VF top = setF(static_cast<float>(-1 - group.anchorY)) - r.y;
    const VF ax = left * r.inverseDx, ay = top * r.inverseDy;
    const VF bx = hn::MulAdd(setF(static_cast<float>(cut.cellsX + 2)), r.inverseDx, ax);
    const VF by = hn::MulAdd(setF(static_cast<float>(cut.cellsY + 2)), r.inverseDy, ay);
    const VF from = hn::Max(w, hn::Max(hn::Min(ax, bx), hn::Min(ay, by)));
    const VF to = hn::Min(hn::Max(ax, bx), hn::Max(ay, by));
    const auto height = [&](VF at) { return hn::MulAdd(at, hn::MulAdd(r.bend, at, r.dz), r.z); };
    const auto slope = [&](VF at) { return hn::MulAdd(r.bend + r.bend, at, r.dz); };
    // A parabola lies below its chord by at most a quarter of bend (to - from)^2.
    const VF length = to - from, sag = setF(0.25f) * r.bend * length * length;
    const VF steady = setF(e.height1), from1 = height(from), to1 = height(to);
    VF lowest = hn::Min(from1, to1) - sag;
    lowest = hn::IfThenElse(slope(to) < hn::Neg(steady), to1, lowest);
    lowest = hn::IfThenElse(slope(from) > steady, from1, lowest);
    const VF reach = hn::Max(hn::Abs(from), hn::Abs(to));
    // The errors are those near the anchor, where the bend counts for little: here it may not.
    const VF bent = setF(4.0f * kFloatError) * r.bend * reach;
    const VF error = hn::MulAdd(steady + bent, reach, setF(e.height0));
    const VF highest = setF(cut.maxZ - group.anchorZ);
    const VF deepest = setF(cut.minZ - group.anchorZ);
    const MF above = lowest - error > highest, below = hn::Max(from1, to1) + error < deepest;
    return maskI(hn::Or(from > to, hn::Or(above, below)));
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

/// Puts lanes at `begin`, a little before: for its rounding, and this division's. Of lanes that are
/// past, as much is known as of the row below.
HWY_INLINE MarchPlace beginLanes(const TerrainCut& cut, const MarchGroup& group,
                                 const MarchErrors& e, const ColumnRays& r, VF begin, VF below,
                                 MarchLanes& m, size_t p, MI active) {
    const VI zero = hn::Zero(DI());
    const VF w0 = setF(group.w0);
    const VF ahead = (begin - r.forward0) / r.forward * setF(0.99999f) - w0;
    const VF w = hn::Max(ahead, r.wBegin);
    const VF px = hn::MulAdd(r.dx, w, r.x), py = hn::MulAdd(r.dy, w, r.y);
    const VI x = hn::ConvertTo(DI(), hn::Floor(px)) + setI(group.anchorX);
    const VI y = hn::ConvertTo(DI(), hn::Floor(py)) + setI(group.anchorY);
    storeF(active, (w * setF(0.9999f) + w0) * r.length, m.clear + p);

    const VI lastX = setI(cut.cellsX - 1), lastY = setI(cut.cellsY - 1);
    const MI outside = hn::Or(hn::Or(x < zero, y < zero), hn::Or(x > lastX, y > lastY));
    const MI past = hn::And(active, hn::Ne(loadI(m.past + p), zero));
    MI gone = noLanes();
    if (!hn::AllFalse(DI(), past)) {
        gone = hn::And(past, isPast(cut, group, e, r, w));
        storeI(gone, setI(kMarchMiss), m.result + p);
        storeF(gone, below, m.forward + p);
    }
    return {hn::Min(hn::Max(x, zero), lastX), hn::Min(hn::Max(y, zero), lastY), zero,
            hn::AndNot(hn::Or(outside, gone), active)};
}

/// Looks up the tiles of lanes that have left theirs; ends those that are where nothing is drawn.
HWY_INLINE void enterTiles(const TerrainCut& cut, const MarchGroup& group, MarchLanes& m, size_t p,
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
    enterMarchTiles(cut, group.anchorZ, x, y, which, static_cast<int>(hn::Lanes(DI())), m,
                    static_cast<int>(p));
    place.mip = loadI(m.mip + p);
    const MI nothing = hn::Eq(loadI(m.slot + p), setI(static_cast<int32_t>(kNoSlot)));
    place.active = hn::AndNot(nothing, place.active);
}

/// Walks the lanes of a packet that are not `done`.
template <bool kInt16, bool kTriangles>
void marchPacket(const TerrainCut& cut, const Pools& pools, const MarchGroup& group,
                 const MarchRow& row, const MarchErrors& e, MI done, MarchLanes& m, size_t p) {
    const VI zero = hn::Zero(DI());
    const VF below = beginOf(row, m, p), w0 = setF(group.w0);
    const VF begin = hn::Max(below, loadF(m.sure + p));
    const MI begun = maskI(begin >= hn::Zero(DF()));
    m.calm[p / hn::Lanes(DF())] = kNotCalm;
    hn::Store(hn::IfThenElseZero(begun, setI(1)), DI(), m.begun + p);
    storeI(hn::Not(done), zero, m.result + p);
    storeF(hn::Not(done), setF(-1.0f), m.forward + p);
    VI steps = hn::IfThenElseZero(done, loadI(m.steps + p));
    hn::Store(steps, DI(), m.steps + p);
    if (hn::AllFalse(DI(), begun)) return;
    ColumnRays r = makeRays(group, row.index, p);
    addInverses(cut, group, r);
    MarchPlace place = beginLanes(cut, group, e, r, begin, below, m, p, hn::AndNot(done, begun));
    MI hits = noLanes();
    for (int cell = 0; cell < kMostCells && !hn::AllFalse(DI(), place.active); ++cell) {
        enterTiles(cut, group, m, p, place);
        const VI x = place.x, y = place.y;
        const MarchCell k = lookAt<kInt16, kTriangles>(cut, pools, group, r, e, m, p, x, y,
                                                       place.mip, hn::Or(place.active, hits));
        const MI known = hn::AndNot(k.open, place.active);
        const MI told = hn::AndNot(k.hole, hn::And(known, maskI(k.f0 > k.error)));
        const MI passes = hn::Or(hn::And(known, k.hole), hn::And(told, maskI(k.low > k.error)));
        hits = hn::Or(hits, hn::And(told, maskI(k.low < hn::Neg(k.error))));
        steps = steps + hn::IfThenElseZero(place.active, setI(1));
        place.active = noLanes();
        if (!hn::AllFalse(DI(), passes)) {
            const MarchStep next = nextCell(cut, group, r, k, x, y, place.mip);
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
            storeHits(group, r, k, e, m, p, x, y, place.mip, hits);
            break;
        }
    }
    hn::Store(steps, DI(), m.steps + p);
    const MI missed = hn::Eq(loadI(m.result + p), setI(kMarchMiss));
    if (hn::AllFalse(DI(), missed) &&
        hn::AllTrue(DI(), hn::Eq(loadI(m.slot + p), setI(m.slot[p]))) && m.slot[p] >= 0)
        m.calm[p / hn::Lanes(DF())] = kCalm;
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

/// Hits of a packet.
struct HitLanes {
    VF t;
    VI slot, cell;
    VF u, v;
    VI rest;  ///< steps, mip and flags
};

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void writeAllHits(const HitLanes& k, Hit* hits) {
    const auto rest = static_cast<uint32_t>(hn::GetLane(k.rest));
    *hits = {hn::GetLane(k.t),
             static_cast<uint32_t>(hn::GetLane(k.slot)),
             static_cast<uint32_t>(hn::GetLane(k.cell)),
             hn::GetLane(k.u),
             hn::GetLane(k.v),
             static_cast<uint16_t>(rest),
             static_cast<uint8_t>(rest >> 16),
             static_cast<uint8_t>(rest >> 24)};
}
#else
/// Two hits are three blocks of 16 bytes: (t, slot, cell, u), (v, rest, t, slot), (cell, u, v,
/// rest); each block of the vectors below belongs to two neighbours.
HWY_INLINE void writeAllHits(const HitLanes& k, Hit* hits) {
    static_assert(sizeof(Hit) == 24 && offsetof(Hit, cell) == 8 && offsetof(Hit, v) == 16);
    const hn::RepartitionToWide<DU> d64;
    const DU d;
    const auto t = hn::BitCast(d, k.t), slot = hn::BitCast(d, k.slot),
               cell = hn::BitCast(d, k.cell), u = hn::BitCast(d, k.u), v = hn::BitCast(d, k.v),
               rest = hn::BitCast(d, k.rest);
    alignas(64) uint64_t blocks[3][8];
    const auto write = [&](auto a, auto b, auto c, size_t first) {
        hn::Store(hn::InterleaveLower(d64, a, b), d64, blocks[0]);
        hn::Store(hn::OddEven(a, c), d64, blocks[1]);
        hn::Store(hn::InterleaveUpper(d64, b, c), d64, blocks[2]);
        for (size_t lane = 0; lane < hn::Lanes(d); lane += 4)
            for (size_t part = 0; part < 3; ++part)
                std::memcpy(reinterpret_cast<char*>(hits + lane + first) + 16 * part,
                            blocks[part] + lane / 2, 16);
    };
    const auto wide = [&](auto x) { return hn::BitCast(d64, x); };
    write(wide(hn::InterleaveLower(d, t, slot)), wide(hn::InterleaveLower(d, cell, u)),
          wide(hn::InterleaveLower(d, v, rest)), 0);
    write(wide(hn::InterleaveUpper(d, t, slot)), wide(hn::InterleaveUpper(d, cell, u)),
          wide(hn::InterleaveUpper(d, v, rest)), 2);
}
#endif

HWY_INLINE HitLanes hitsOf(const MarchLanes& m, size_t p) {
    const MI valid = hn::Eq(loadI(m.result + p), setI(kMarchHit));
    const VI flags = hn::IfThenElseZero(valid, setI(int32_t{kHitValid} << 24));
    return {loadF(m.t + p),
            loadI(m.slot + p),
            loadI(m.cell + p),
            loadF(m.u + p),
            loadF(m.v + p),
            hn::Or(hn::Or(loadI(m.steps + p), hn::ShiftLeft<16>(loadI(m.mip + p))), flags)};
}

/// Notes the columns [begin, end) that are left.
void noteLeft(MarchLanes& m, int begin, int end, MarchCounts& counts) {
    for (int c = begin; c < end; ++c)
        if (m.result[c] != kMarchHit && m.result[c] != kMarchMiss) m.left[counts.left++] = c;
}

/// One row's march.
template <bool kInt16, bool kTriangles>
class RowMarch {
public:
    RowMarch(const TerrainCut& cut, const MarchGroup* groups, const MarchRow& row, int begin,
             int end, MarchLanes& m, Hit* hits)
        : cut_(cut),
          groups_(groups),
          row_(row),
          begin_(begin),
          end_(end),
          m_(m),
          hits_(hits),
          pools_(makePools(cut, 0.0f)) {}

    MarchCounts march() {
        for (int p = begin_ / kLanes * kLanes; p < end_; p += kLanes) {
            if (!isCalm(p)) {
                marchOne(p, noLanes());
            } else if (isWhole(p) && isWhole(p + kLanes) && isCalm(p + kLanes)) {
                marchTwoCalm(p);
                p += kLanes;
            } else {
                marchCalm(p);
            }
        }
        std::fill_n(m_.disturbed, kMarchGroups, false);
        return counts_;
    }

private:
    static constexpr int kLanes = static_cast<int>(HWY_LANES(float) < 16 ? HWY_LANES(float) : 16);
    static constexpr int kCalmCells = 8;  ///< walked the short way
    using Packet = FirstPacket<kInt16, kTriangles>;

    /// The packet is to be tried the short way.
    HWY_INLINE bool isCalm(int p) {
        if (p >= end_) return false;
        uint8_t& calm = m_.calm[p / kLanes];
        const MarchGroup& group = groupOf(p);
        if (calm == kNotCalm || !(group.span > 0) || m_.disturbed[p / kMarchGroupColumns])
            return false;
        if (calm == kCalm) {
            if (!standOn(cut_, group, m_, static_cast<size_t>(p), plateauOf(p))) return false;
            calm = kCalmAnchored;
        }
        return true;
    }
    HWY_INLINE const MarchGroup& groupOf(int p) const { return groups_[p / kMarchGroupColumns]; }
    HWY_INLINE MarchPlateau& plateauOf(int p) const { return m_.plateaus[p / kLanes]; }
    HWY_INLINE bool isWhole(int p) const { return p >= begin_ && p + kLanes <= end_; }
    HWY_INLINE Packet packetAt(int p, MF wanted) const {
        const VF begin = beginOf(row_, m_, static_cast<size_t>(p));
        return {groupOf(p), row_.index, plateauOf(p), begin, wanted, static_cast<size_t>(p)};
    }
    HWY_INLINE MF wantedAt(int p) const {
        const VI column = hn::Iota(DI(), p);
        return maskF(hn::AndNot(column < setI(begin_), column < setI(end_)));
    }

    HWY_NOINLINE void marchCalm(int p) {
        const MF wanted = wantedAt(p);
        Packet a = packetAt(p, wanted);
        if (!a.stands()) return marchOne(p, noLanes());
        a.parkOthers();
        for (int cell = 0; cell < kCalmCells; ++cell) {
            if (cell > 0) a.advance();
            a.loadCells(cut_, pools_);
            a.lookAtCells();
            a.solve();
            a.judge();
            if (!a.isActive()) break;
        }
        settleCalm(p, a.hits(), wanted);
    }

    HWY_INLINE void marchTwoCalm(int p) {
        const MF all = hn::Not(hn::MaskFromVec(hn::Zero(DF())));
        Packet a = packetAt(p, all), b = packetAt(p + kLanes, all);
        if (!a.stands() || !b.stands()) {
            marchCalm(p);
            marchCalm(p + kLanes);
            return;
        }
        lookAtBoth(a, b);
        if (!a.isActive() && !b.isActive()) {
            finishCalm(p, a.hits());
            finishCalm(p + kLanes, b.hits());
            return;
        }
        for (int cell = 1; cell < kCalmCells && (a.isActive() || b.isActive()); ++cell) {
            a.advance();
            b.advance();
            lookAtBoth(a, b);
        }
        finishCalm(p, a.hits());
        finishCalm(p + kLanes, b.hits());
    }
    HWY_INLINE void lookAtBoth(Packet& a, Packet& b) const {
        a.loadCells(cut_, pools_);
        b.loadCells(cut_, pools_);
        a.lookAtCells();
        b.lookAtCells();
        a.solve();
        b.solve();
        a.judge();
        b.judge();
    }

    /// Ends a packet if all its lanes have hit; else the others go the long way.
    HWY_INLINE void finishCalm(int p, const FirstHits& k) {
        if (!hn::AllTrue(DF(), hn::And(k.told, k.placed))) {
            settleCalm(p, k, hn::Not(hn::MaskFromVec(hn::Zero(DF()))));
            return;
        }
        const MarchPlateau& plateau = plateauOf(p);
        hn::Store(k.forward, DF(), m_.forward + p);
        const VI rest = k.steps + setI(int32_t{kHitValid} << 24 | plateau.mip << 16);
        writeAllHits({k.t, setI(plateau.slot), k.cell, k.u, k.v, rest}, hits_ + p);
        counts_.hits += kLanes;
        counts_.steps += hn::GetLane(hn::SumOfLanes(DI(), k.steps));
    }

    HWY_NOINLINE void settleCalm(int p, FirstHits k, MF wanted) {
        const MI told = maskI(k.told), placed = maskI(k.placed), left = maskI(k.left);
        counts_.steps += hn::GetLane(hn::SumOfLanes(DI(), k.steps));
        hn::Store(k.t, DF(), m_.t + p);
        hn::Store(k.u, DF(), m_.u + p);
        hn::Store(k.v, DF(), m_.v + p);
        hn::Store(hn::IfThenElse(k.told, k.forward, setF(-1.0f)), DF(), m_.forward + p);
        hn::Store(k.clear, DF(), m_.clear + p);
        hn::Store(k.cell, DI(), m_.cell + p);
        hn::Store(k.steps, DI(), m_.steps + p);
        hn::Store(hn::IfThenElseZero(told, select(placed, setI(kMarchHit), setI(kMarchCell))), DI(),
                  m_.result + p);
        hn::Store(setI(1), DI(), m_.begun + p);
        // Few lanes are worth the long way only if the row has none for the tracer yet.
        const MI others = hn::Not(hn::Or(told, hn::Not(maskI(wanted))));
        const bool traced = counts_.left > 0 || !hn::AllFalse(DI(), left);
        if (traced || hn::AllFalse(DI(), hn::AndNot(left, others))) return endPacket(p);
        marchOne(p, hn::Not(hn::AndNot(left, others)));
    }

    /// Marches a packet of which some lanes are done.
    HWY_NOINLINE void marchOne(int p, MI done) {
        const auto first = static_cast<size_t>(p);
        const MarchGroup& group = groupOf(p);
        pools_.anchorZ = group.anchorZ;
        marchPacket<kInt16, kTriangles>(cut_, pools_, group, row_, group.errors, done, m_, first);
        counts_.steps +=
            hn::GetLane(hn::SumOfLanes(DI(), hn::IfThenZeroElse(done, loadI(m_.steps + p))));
        endPacket(p);
    }

    /// Counts and writes what the lanes of a packet have come to.
    void endPacket(int p) {
        const auto first = static_cast<size_t>(p);
        const VI result = loadI(m_.result + p);
        const MI missed = hn::Eq(result, setI(kMarchMiss));
        hn::Store(hn::IfThenElseZero(missed, setI(1)), DI(), m_.past + p);
        if (isWhole(p)) {
            const int hit = static_cast<int>(hn::CountTrue(DI(), hn::Eq(result, setI(kMarchHit))));
            counts_.hits += hit;
            if (hit + static_cast<int>(hn::CountTrue(DI(), missed)) < kLanes)
                noteLeft(m_, p, p + kLanes, counts_);
            writeAllHits(hitsOf(m_, first), hits_ + p);
            return;
        }
        writeHits(m_, p, begin_, end_, hits_);
        for (int c = std::max(p, begin_); c < std::min(p + kLanes, end_); ++c)
            counts_.hits += m_.result[c] == kMarchHit;
        noteLeft(m_, std::max(p, begin_), std::min(p + kLanes, end_), counts_);
    }

    const TerrainCut& cut_;
    const MarchGroup* const groups_;
    const MarchRow row_;
    const int begin_, end_;
    MarchLanes& m_;
    Hit* const hits_;
    Pools pools_;
    MarchCounts counts_;
};

template <bool kInt16, bool kTriangles>
MarchCounts marchRowOver(const TerrainCut& cut, const MarchGroup* groups, const MarchRow& row,
                         int begin, int end, MarchLanes& m, Hit* hits) {
    return RowMarch<kInt16, kTriangles>(cut, groups, row, begin, end, m, hits).march();
}

MarchCounts marchRowLanes(const TerrainCut& cut, const MarchGroup* groups, const MarchRow& row,
                          int begin, int end, MarchLanes& m, Hit* hits) {
    const bool triangles = cut.surface == kSurfaceTriangles, int16 = cut.format == 0;
    const auto march = int16 ? (triangles ? marchRowOver<true, true> : marchRowOver<true, false>)
                             : (triangles ? marchRowOver<false, true> : marchRowOver<false, false>);
    return march(cut, groups, row, begin, end, m, hits);
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
