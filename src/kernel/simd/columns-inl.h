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
HWY_INLINE void storeHits(const MarchTile& tile, const ColumnRays& r, const MarchCell& k,
                          const MarchErrors& e, MarchLanes& m, size_t p, VI x, VI y, VI mip,
                          MI hits) {
    if (hn::AllFalse(DI(), hits)) return;
    const MI fixed = fixHits(tile, r, k, m, p, hits, e.rounding);
    const VI cellMask = setI(kSlotCells - 1);
    const VI cx = hn::And(shiftRight(x, mip), cellMask);
    const VI cy = hn::And(shiftRight(y, mip), cellMask);
    storeI(hits, hn::ShiftLeft<kTileLevels>(cy) + cx, m.cell + p);
    storeI(hits, select(fixed, setI(kMarchHit), setI(kMarchCell)), m.result + p);
}

/// Lanes that have nothing before them from w on: beside or beyond the terrain's rectangle, or
/// above or below all ground wherever they are in it.
HWY_INLINE MI isPast(const TerrainCut& cut, const MarchTile& tile, const MarchErrors& e,
                     const ColumnRays& r, VF w) {
    // One cell around covers the errors of places.
    const VF left = setF(static_cast<float>(-1 - tile.anchorX)) - r.x;
    const VF top = setF(static_cast<float>(-1 - tile.anchorY)) - r.y;
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
    const VF highest = setF(cut.maxZ - static_cast<float>(tile.anchorZ));
    const VF deepest = setF(cut.minZ - static_cast<float>(tile.anchorZ));
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
HWY_INLINE MarchPlace beginLanes(const TerrainCut& cut, const MarchTile& tile, const MarchErrors& e,
                                 const ColumnRays& r, VF begin, VF below, MarchLanes& m, size_t p,
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
        gone = hn::And(past, isPast(cut, tile, e, r, w));
        storeI(gone, setI(kMarchMiss), m.result + p);
        storeF(gone, below, m.forward + p);
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
    const VF below = beginOf(row, m, p), w0 = setF(static_cast<float>(tile.w0));
    const VF begin = hn::Max(below, loadF(m.sure + p));
    const MI begun = maskI(begin >= hn::Zero(DF()));
    // In the row below, all of them needed one cell: most likely they do here, too.
    const bool near = hn::AllTrue(DI(), hn::Eq(loadI(m.steps + p), setI(1)));
    hn::Store(zero, DI(), m.result + p);
    hn::Store(zero, DI(), m.steps + p);
    hn::Store(hn::IfThenElseZero(begun, setI(1)), DI(), m.begun + p);
    hn::Store(setF(-1.0f), DF(), m.forward + p);
    if (hn::AllFalse(DI(), begun)) return;
    ColumnRays r = makeRays(tile, row, p);
    MI done = noLanes();
    const MI past = hn::Ne(loadI(m.past + p), zero);
    if (near && !tile.eyeOutside && hn::AllTrue(DI(), hn::AndNot(past, begun))) {
        done = hitFirstCells<kInt16, kTriangles>(cut, pools, tile, r, e, begin, m, p);
        hn::Store(hn::IfThenElseZero(done, setI(1)), DI(), m.steps + p);
        if (hn::AllTrue(DI(), done)) return;
    }
    addInverses(cut, tile, r);
    MarchPlace place = beginLanes(cut, tile, e, r, begin, below, m, p, hn::AndNot(done, begun));
    MI hits = noLanes();
    VI steps = hn::IfThenElseZero(done, setI(1));
    for (int cell = 0; cell < kMostCells && !hn::AllFalse(DI(), place.active); ++cell) {
        enterTiles(cut, tile, m, p, place);
        const VI x = place.x, y = place.y;
        const MarchCell k = lookAt<kInt16, kTriangles>(cut, pools, tile, r, e, m, p, x, y,
                                                       place.mip, hn::Or(place.active, hits));
        const MI known = hn::AndNot(k.open, place.active);
        const MI told = hn::AndNot(k.hole, hn::And(known, maskI(k.f0 > k.error)));
        const MI passes = hn::Or(hn::And(known, k.hole), hn::And(told, maskI(k.low > k.error)));
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

/// Notes the columns [begin, end) that are left.
void noteLeft(MarchLanes& m, int begin, int end, MarchCounts& counts) {
    for (int c = begin; c < end; ++c)
        if (m.result[c] != kMarchHit && m.result[c] != kMarchMiss) m.left[counts.left++] = c;
}

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
            if (hit + static_cast<int>(hn::CountTrue(DI(), missed)) < kLanes)
                noteLeft(m, p, p + kLanes, counts);
            counts.steps += hn::GetLane(hn::SumOfLanes(DI(), loadI(m.steps + p)));
            writeAllHits(m, first, hits);
            continue;
        }
        writeHits(m, p, begin, end, hits);
        for (int c = std::max(p, begin); c < std::min(p + kLanes, end); ++c) {
            counts.hits += m.result[c] == kMarchHit;
            counts.steps += m.steps[c];
        }
        noteLeft(m, std::max(p, begin), std::min(p + kLanes, end), counts);
    }
    return counts;
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
