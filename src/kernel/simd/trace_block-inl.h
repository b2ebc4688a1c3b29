// SPDX-License-Identifier: Apache-2.0
// The maximum-mipmap traversal in SIMD lanes (docs/traversal.md): one ray a lane, each with its own
// tile, level and cell. Every comparison carries the float ray's error, so a lane ends as a certain
// miss, a certain hit, or uncertain (then kernel/exact decides).

#if defined(TERRAY_TRACE_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_TRACE_BLOCK_INL_H_
#undef TERRAY_TRACE_BLOCK_INL_H_
#else
#define TERRAY_TRACE_BLOCK_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"
#include "kernel/simd/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {

/// One step of the lanes that stand in a tile's pyramid above its cells.
HWY_INLINE void stepNodes(const TerrainCut& cut, const Pools& pools, Packet& k, MI lanes) {
    RayBlock& b = k.b;
    const VI one = setI(1);
    const VI inner = k.level - loadI(b.mip + k.p);
    const VI log2Side = setI(kTileLevels) - inner;
    const VI sideMask = shiftLeft(one, log2Side) - one;
    const VI ix = hn::And(shiftRight(k.x, k.level), sideMask);
    const VI iy = hn::And(shiftRight(k.y, k.level), sideMask);
    // levelOffset(inner) = 87381 - (4^(10 - inner) - 1) / 3, whose binary digits are 0101...
    const VI below = shiftLeft(one, setI(20) - inner - inner) - one;
    const VI offset = setI(static_cast<int32_t>(kSlotBounds)) - hn::And(below, setI(0x55555555));
    const VI index = offset + shiftLeft(iy, log2Side) + ix;
    const VI bytes = inPool(lanes, loadI(b.boundsOffset + k.p) + hn::ShiftLeft<2>(index));
    const VI code = hn::GatherOffset(DI(), pools.bounds, bytes);

    const BlockExit e = leaveBlock(k);
    const HeightRange r = heightRange(k, e.t);
    const VI hi = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), code)));
    const VI lo = hn::And(code, setI(0xFFFF));
    const VF step = loadF(b.boundsStep + k.p), base = loadF(b.boundsZ + k.p);
    const VF error = errorAnywhere(k, e.t);
    const VF top = hn::MulAdd(step, hn::ConvertTo(DF(), hi), base) + error;
    const VF bottom = hn::MulAdd(step, hn::ConvertTo(DF(), lo), base) - error;
    const MI empty = lo > hi;
    const MI above = maskI(r.lo > top);
    const MI skip = hn::And(lanes, hn::Or(hn::Or(above, empty), maskI(r.hi < bottom)));
    const VI side = hn::IfThenZeroElse(empty, select(above, one, setI(-1)));
    if (!hn::AllFalse(DI(), skip)) {
        // A ray that clears this block by less than the block's own relief rarely clears its
        // parent.
        const VF clears = hn::Max(r.lo - top, bottom - r.hi);
        const MI climb = hn::Or(empty, maskI(clears > top - bottom));
        moveOn(cut, k, keepSide(k, skip, side), e, lanes, climb);
    }
    const MI down = hn::AndNot(skip, lanes);
    if (!hn::AllFalse(DI(), down)) goDown(k, down, e, r.entry, top, error);
    storeI(lanes, loadI(b.steps + k.p) + one, b.steps + k.p);
}

/// What a cell does to a ray: f at the entry, and its least and greatest value up to the exit.
struct CellRange {
    VF entry, least, greatest;
    MI unsure;  ///< a corner of constant quadrants is too near to tell
};

HWY_INLINE CellRange rangeBilinear(const CellPosts& c, VF u, VF v, VF du, VF dv, VF z, VF slope,
                                   VF bend, VF length) {
    const LeafQuadratic q = leafBilinear(c.h00, c.h10, c.h01, c.h11, u, v, du, dv, z, slope, bend);
    const VF end = leafAt(q, length);
    const VF extremum = q.f1 / (setF(-2.0f) * q.f2);  // NaN or infinite where f is straight
    const VF inside = hn::Min(hn::Max(extremum, hn::Zero(DF())), length);
    const VF turn = hn::IfThenElse(extremum == extremum, leafAt(q, inside), end);
    return {q.f0, hn::Min(hn::Min(q.f0, end), turn), hn::Max(hn::Max(q.f0, end), turn), noLanes()};
}

/// Two triangles: the lower one's plane, and above the diagonal d (u + v - 1) on top of it, d being
/// the bilinear cell's twist. Along the ray that is one parabola on either side of the diagonal. A
/// break that is off by a rounding moves f at a ridge or a valley by no more than d times that
/// rounding, which the cell's error holds.
HWY_INLINE CellRange rangeTriangles(const CellPosts& c, VF u, VF v, VF du, VF dv, VF z, VF slope,
                                    VF bend, VF length) {
    const VF zero = hn::Zero(DF());
    const VF b = c.h10 - c.h00, cc = c.h01 - c.h00, d = (c.h11 - c.h01) - b;
    const VF beyond = (u + v) - setF(1.0f), rate = du + dv;
    const VF f0 = z - hn::MulAdd(cc, v, hn::MulAdd(b, u, c.h00));
    const VF lower = slope - hn::MulAdd(cc, dv, b * du), upper = lower - d * rate;
    const auto at = [&](VF s) {
        const VF plane = hn::MulAdd(s, hn::MulAdd(bend, s, lower), f0);
        return plane - d * hn::Max(hn::MulAdd(rate, s, beyond), zero);
    };
    const VF meets = hn::Neg(beyond) / rate;  // NaN or infinite along the diagonal
    const VF middle = hn::IfThenElse(meets == meets, hn::Min(hn::Max(meets, zero), length), length);
    const MF startsUpper = beyond > zero;
    const VF twice = setF(-2.0f) * bend;
    const VF first = hn::IfThenElse(startsUpper, upper, lower) / twice;
    const VF second = hn::IfThenElse(startsUpper, lower, upper) / twice;
    const VF entry = at(zero), kink = at(middle), end = at(length);
    const VF dip1 = hn::IfThenElse(first == first, at(hn::Min(hn::Max(first, zero), middle)), kink);
    const VF dip2 =
        hn::IfThenElse(second == second, at(hn::Min(hn::Max(second, middle), length)), end);
    const VF least = hn::Min(hn::Min(entry, hn::Min(kink, end)), hn::Min(dip1, dip2));
    return {entry, least, hn::Max(entry, hn::Max(kink, end)), noLanes()};
}

/// Nearest post: the quadrants in the order of the ray; f jumps between them (walls).
HWY_INLINE CellRange rangeConstant(const CellPosts& c, VF u, VF v, VF du, VF dv, VF z, VF slope,
                                   VF bend, VF length, VF shift) {
    const VF half = setF(0.5f), zero = hn::Zero(DF()), never = setF(1e30f);
    const VF su = hn::IfThenElse(hn::Abs(du) > setF(1e-20f), (half - u) / du, never);
    const VF sv = hn::IfThenElse(hn::Abs(dv) > setF(1e-20f), (half - v) / dv, never);
    const VF first = hn::Min(hn::Max(hn::Min(su, sv), zero), length);
    const VF second = hn::Min(hn::Max(hn::Max(su, sv), zero), length);
    const VF lowest = hn::Neg(slope) / (bend + bend);
    CellRange r{zero, never, hn::Neg(never), noLanes()};
    VF from = zero;
    const VF ends[3] = {first, second, length};
    for (int part = 0; part < 3; ++part) {
        const VF to = ends[part];
        const VF mid = (from + to) * half;
        const MF right = hn::MulAdd(du, mid, u) >= half, lower = hn::MulAdd(dv, mid, v) >= half;
        const VF h = hn::IfThenElse(lower, hn::IfThenElse(right, c.h11, c.h01),
                                    hn::IfThenElse(right, c.h10, c.h00));
        const auto at = [&](VF s) { return hn::MulAdd(s, hn::MulAdd(bend, s, slope), z) - h; };
        const VF f0 = at(from), f1 = at(to);
        const VF low = hn::IfThenElse(lowest == lowest, at(hn::Min(hn::Max(lowest, from), to)), f1);
        if (part == 0) r.entry = f0;
        const MF real = part == 0 ? hn::Or(to > from, length <= zero) : to > from;
        r.least = hn::IfThenElse(real, hn::Min(r.least, hn::Min(hn::Min(f0, f1), low)), r.least);
        r.greatest = hn::IfThenElse(real, hn::Max(r.greatest, hn::Max(f0, f1)), r.greatest);
        from = to;
    }
    // Near a quadrant's corner, or entering or leaving along its border, the order cannot be told.
    const VF eu = hn::MulAdd(du, length, u), ev = hn::MulAdd(dv, length, v);
    const VF near = shift + shift;
    const MF corner = hn::And(hn::Abs(hn::MulAdd(du, sv, u) - half) < near, hn::Abs(sv) < never);
    const MF borders = hn::Or(hn::Or(hn::Abs(u - half) < near, hn::Abs(v - half) < near),
                              hn::Or(hn::Abs(eu - half) < near, hn::Abs(ev - half) < near));
    r.unsure = maskI(hn::Or(corner, borders));
    return r;
}

/// Tests the lanes that stand at a cell.
template <bool kInt16>
HWY_INLINE void stepCells(const TerrainCut& cut, const Pools& pools, Packet& k, MI lanes) {
    RayBlock& b = k.b;
    const VI cellMask = setI(kSlotCells - 1);
    const VI cx = hn::And(shiftRight(k.x, k.level), cellMask);
    const VI cy = hn::And(shiftRight(k.y, k.level), cellMask);
    const CellPosts c = loadPosts<kInt16>(pools,
                                          {loadI(b.postsOffset + k.p), hn::Zero(DI()),
                                           loadF(b.postsZ + k.p), loadF(b.postsStep + k.p)},
                                          cx, cy, lanes);
    const BlockExit e = leaveBlock(k);

    // 2^-mip from its exponent bits
    const VF inverse = hn::BitCast(DF(), hn::ShiftLeft<23>(setI(127) - k.level));
    const VF dx = loadF(b.dx + k.p), dy = loadF(b.dy + k.p);
    const VF x0 = hn::ConvertTo(DF(), e.x0 - loadI(b.anchorX + k.p)) - loadF(b.fx + k.p);
    const VF y0 = hn::ConvertTo(DF(), e.y0 - loadI(b.anchorY + k.p)) - loadF(b.fy + k.p);
    const VF u = hn::MulSub(dx, k.t, x0) * inverse, v = hn::MulSub(dy, k.t, y0) * inverse;
    const VF du = dx * inverse, dv = dy * inverse;
    const VF slope = hn::MulAdd(k.bend + k.bend, k.t, k.dz);
    const VF length = e.t - k.t;

    // Cells at the tile's rim have neighbours in other tiles: their slope may be anyone's.
    const MI rim = hn::Or(hn::Or(hn::Eq(cx, hn::Zero(DI())), hn::Eq(cy, hn::Zero(DI()))),
                          hn::Or(hn::Eq(cx, cellMask), hn::Eq(cy, cellMask)));
    const VF delta = hn::IfThenElse(maskF(rim), setF(cut.maxDelta), loadF(b.tileDelta + k.p));
    const VF shift = shiftAt(k, e.t) * inverse;
    const VF error = hn::MulAdd(delta, shift + shift + setF(4 * kFloatError), errorOfRay(k, e.t));
    const VF z = k.heightAt(k.t);
    const CellRange r = cut.surface == kSurfaceBilinear
                            ? rangeBilinear(c, u, v, du, dv, z, slope, k.bend, length)
                        : cut.surface == kSurfaceTriangles
                            ? rangeTriangles(c, u, v, du, dv, z, slope, k.bend, length)
                            : rangeConstant(c, u, v, du, dv, z, slope, k.bend, length, shift);

    const MF above = r.least > error, below = r.greatest < hn::Neg(error);
    const MF entersAbove = r.entry > error, entersBelow = r.entry < hn::Neg(error);
    const MI crosses = maskI(hn::Or(hn::And(entersAbove, r.least < hn::Neg(error)),
                                    hn::And(entersBelow, r.greatest > error)));
    const VI one = setI(1);
    const VI entrySide = select(maskI(entersAbove), one, setI(-1));
    const MI passes =
        hn::And(lanes, hn::Or(c.hole, hn::AndNot(r.unsure, maskI(hn::Or(above, below)))));
    const MI hits = hn::AndNot(hn::Or(passes, r.unsure), hn::And(lanes, crosses));
    const MI onSide = keepSide(k, hn::Or(passes, hits), hn::IfThenZeroElse(c.hole, entrySide));
    const MI certain = hn::And(onSide, hits);
    storeI(certain, setI(kResultHit), b.result + k.p);
    const MI unclear = hn::AndNot(hn::Or(passes, hits), lanes);
    storeI(unclear, setI(kResultUncertain), b.result + k.p);
    storeI(hn::Or(certain, unclear), setI(kLaneDone), b.state + k.p);
    const MI onward = hn::And(onSide, passes);
    if (!hn::AllFalse(DI(), onward)) {
        const VF clears = hn::Max(r.least, hn::Neg(r.greatest));
        const MI climb = hn::Or(c.hole, maskI(clears > hn::Abs(c.h11 - c.h00)));
        moveOn(cut, k, onward, e, lanes, climb);
    }
    storeI(lanes, loadI(b.steps + k.p) + one, b.steps + k.p);
}

/// Lanes enter the tile that a square draws: its description comes into the block.
HWY_INLINE void enterTiles(const TerrainCut& cut, const Pools& pools, Packet& k, MI lanes,
                           VI slot) {
    RayBlock& b = k.b;
    const VI at = hn::IfThenElseZero(lanes, slot * setI(sizeof(TileDesc)));
    const auto field = [&](size_t offset) {
        return hn::GatherOffset(DI(), pools.tiles, at + setI(static_cast<int32_t>(offset)));
    };
    const auto fieldF = [&](size_t offset) { return hn::BitCast(DF(), field(offset)); };
    const VI middle = setI(INT32_MIN);
    const VI posts = field(offsetof(TileDesc, posts));
    const VI postBytes = cut.format == 0 ? hn::ShiftLeft<1>(posts) : hn::ShiftLeft<2>(posts);
    const VI mip =
        hn::And(field(offsetof(TileDesc, mipFlags)), setI(static_cast<int32_t>(kTileMipMask)));
    const VF anchor = setF(pools.anchorZ);
    storeI(lanes, slot, b.slot + k.p);
    storeI(lanes, mip, b.mip + k.p);
    storeI(lanes, hn::Xor(postBytes, middle), b.postsOffset + k.p);
    storeI(lanes, hn::Xor(hn::ShiftLeft<2>(field(offsetof(TileDesc, bounds))), middle),
           b.boundsOffset + k.p);
    storeF(lanes, fieldF(offsetof(TileDesc, z0)) - anchor, b.postsZ + k.p);
    storeF(lanes, fieldF(offsetof(TileDesc, zStep)), b.postsStep + k.p);
    storeF(lanes, fieldF(offsetof(TileDesc, boundsZ0)) - anchor, b.boundsZ + k.p);
    storeF(lanes, fieldF(offsetof(TileDesc, boundsStep)), b.boundsStep + k.p);
    storeF(lanes, fieldF(offsetof(TileDesc, maxDelta)), b.tileDelta + k.p);
    // One below the whole tile, or as deep as a head start has shown to be of use.
    const VI wanted = hn::Min(loadI(b.entryLevel + k.p), mip + setI(kTileLevels - 1));
    storeI(lanes, hn::Max(wanted, mip + setI(1)), b.level + k.p);
    storeI(lanes, setI(kEnterAtTop), b.entryLevel + k.p);
    storeI(lanes, setI(kLaneTile), b.state + k.p);
}

/// One step of the lanes that stand in the directory.
HWY_INLINE void stepDirectory(const TerrainCut& cut, const Pools& pools, Packet& k, MI lanes) {
    RayBlock& b = k.b;
    const VI one = setI(1);
    const VI row =
        hn::IfThenElseZero(lanes, (k.level - setI(kTileLevels)) * setI(sizeof(DirectoryLevel)));
    const VI first = hn::GatherOffset(DI(), pools.levels, row);
    const VI columns = hn::GatherOffset(DI(), pools.levels, row + setI(4));
    const VI index = first + shiftRight(k.y, k.level) * columns + shiftRight(k.x, k.level);
    const VI at = hn::IfThenElseZero(lanes, hn::ShiftLeft<4>(index));
    const VF anchor = setF(pools.anchorZ);
    const VF minZ = hn::BitCast(DF(), hn::GatherOffset(DI(), pools.squares, at)) - anchor;
    const VF maxZ = hn::BitCast(DF(), hn::GatherOffset(DI(), pools.squares, at + setI(4))) - anchor;
    const VI slot = hn::GatherOffset(DI(), pools.squares, at + setI(8));
    const VI state = hn::GatherOffset(DI(), pools.squares, at + setI(12));

    const BlockExit e = leaveBlock(k);
    const HeightRange r = heightRange(k, e.t);
    const VF error = errorAnywhere(k, e.t);
    const MI covered = hn::And(lanes, hn::Eq(state, setI(kSquareCovered)));
    storeI(covered, k.level + one, b.level + k.p);
    const MI here = hn::AndNot(covered, lanes);
    const MI empty = hn::Eq(state, setI(kSquareEmpty));
    const MI above = maskI(r.lo > maxZ + error), below = maskI(r.hi < minZ - error);
    const MI skip = hn::And(here, hn::Or(empty, hn::Or(above, below)));
    const VI side = hn::IfThenZeroElse(empty, select(above, one, setI(-1)));
    if (!hn::AllFalse(DI(), skip)) {
        moveOn(cut, k, keepSide(k, skip, side), e, noLanes(), skip);
    }
    const MI inside = hn::AndNot(skip, here);
    const MI drawn = hn::And(inside, hn::Eq(state, setI(kSquareDrawn)));
    const MI down = hn::AndNot(drawn, inside);
    if (!hn::AllFalse(DI(), down)) goDown(k, down, e, r.entry, maxZ + error, error);
    if (!hn::AllFalse(DI(), drawn)) enterTiles(cut, pools, k, drawn, slot);
    storeI(lanes, loadI(b.steps + k.p) + one, b.steps + k.p);
}

/// One step of a packet; false when all of its lanes are done.
template <bool kInt16>
HWY_INLINE bool stepPacket(const TerrainCut& cut, const Pools& pools, RayBlock& b, size_t p) {
    const VI state = loadI(b.state + p);
    const MI active = hn::Ne(state, hn::Zero(DI()));
    if (hn::AllFalse(DI(), active)) return false;
    Packet k = loadPacket(b, p);
    const MI inDirectory = hn::Eq(state, setI(kLaneDirectory));
    const MI atCell = hn::And(hn::Eq(state, setI(kLaneTile)), hn::Eq(k.level, loadI(b.mip + p)));
    const MI atNode = hn::AndNot(hn::Or(inDirectory, atCell), active);
    const size_t cells = hn::CountTrue(DI(), atCell);
    const size_t nodes = hn::CountTrue(DI(), atNode);
    if (!hn::AllFalse(DI(), inDirectory)) stepDirectory(cut, pools, k, inDirectory);
    if (nodes != 0) stepNodes(cut, pools, k, atNode);
    // A cell's test costs several steps: wait until enough lanes want one.
    if (cells * 3 > hn::CountTrue(DI(), active) || (cells != 0 && nodes == 0))
        stepCells<kInt16>(cut, pools, k, atCell);
    return true;
}

template <bool kInt16>
void traceLanes(const TerrainCut& cut, const Pools& pools, RayBlock& b, int count) {
    constexpr size_t kLanes = HWY_LANES(float) < 16 ? HWY_LANES(float) : 16;
    size_t starts[kBlockRays];
    size_t packets = 0;
    for (size_t p = 0; p < static_cast<size_t>(count); p += kLanes) starts[packets++] = p;
    while (packets !=
           0) {  // in turns, so that one packet's gathers hide behind the others' arithmetic
        size_t left = 0;
        for (size_t q = 0; q < packets; ++q)
            if (stepPacket<kInt16>(cut, pools, b, starts[q])) starts[left++] = starts[q];
        packets = left;
    }
}

void traceBlockLanes(const TerrainCut& cut, RayBlock& b, int count) {
    const Pools pools = makePools(cut, 0.5f * (cut.minZ + cut.maxZ));
    if (cut.format == 0)
        traceLanes<true>(cut, pools, b, count);
    else
        traceLanes<false>(cut, pools, b, count);
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
