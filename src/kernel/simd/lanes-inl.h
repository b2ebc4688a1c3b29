// SPDX-License-Identifier: Apache-2.0
// What every step of the SIMD traversal is made of: lanes in and out of a block, where a ray leaves
// its block, how high it runs there, and where it goes next.

#if defined(TERRAY_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAY_LANES_INL_H_
#undef TERRAY_LANES_INL_H_
#else
#define TERRAY_LANES_INL_H_
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "hwy/highway.h"
#include "kernel/simd/block.h"

HWY_BEFORE_NAMESPACE();
namespace terray::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using MF = hn::Mask<DF>;
using MI = hn::Mask<DI>;

#define real VF
#define LEAF_FN HWY_INLINE
#include "kernel/leaf/leaf.h.inl"
#undef LEAF_FN
#undef real

HWY_INLINE VI loadI(const int32_t* p) { return hn::Load(DI(), p); }
HWY_INLINE VF loadF(const float* p) { return hn::Load(DF(), p); }
HWY_INLINE void storeI(MI mask, VI value, int32_t* p) { hn::BlendedStore(value, mask, DI(), p); }
HWY_INLINE void storeF(MI mask, VF value, float* p) {
    hn::BlendedStore(value, hn::RebindMask(DF(), mask), DF(), p);
}
HWY_INLINE MI maskI(MF m) { return hn::RebindMask(DI(), m); }
HWY_INLINE MF maskF(MI m) { return hn::RebindMask(DF(), m); }
HWY_INLINE VI setI(int32_t v) { return hn::Set(DI(), v); }
HWY_INLINE VF setF(float v) { return hn::Set(DF(), v); }
HWY_INLINE VI shiftRight(VI v, VI bits) { return v >> bits; }
HWY_INLINE VI shiftLeft(VI v, VI bits) { return v << bits; }
HWY_INLINE VI select(MI m, VI a, VI b) { return hn::IfThenElse(m, a, b); }

HWY_INLINE MI noLanes() { return hn::MaskFromVec(hn::Zero(DI())); }

/// Offsets of the lanes that read; the others read the pool's first bytes.
HWY_INLINE VI inPool(MI lanes, VI bytes) { return select(lanes, bytes, setI(INT32_MIN)); }

/// The pools as the gathers want them: base pointers in the middle, so that 32-bit offsets reach 4
/// GiB.
struct Pools {
    const int32_t* bounds;
    const float* posts;
    const int32_t* tiles;
    const int32_t* squares;
    const int32_t* levels;
    float anchorZ;
};
HWY_INLINE Pools makePools(const TerrainCut& cut, float anchorZ) {
    const auto middle = [](const void* pool) {
        return reinterpret_cast<uintptr_t>(pool) + 0x80000000u;
    };
    return {reinterpret_cast<const int32_t*>(middle(cut.bounds)),
            reinterpret_cast<const float*>(middle(cut.posts)),
            reinterpret_cast<const int32_t*>(cut.tiles),
            reinterpret_cast<const int32_t*>(cut.squares),
            reinterpret_cast<const int32_t*>(cut.levels),
            anchorZ};
}

/// The four posts of each lane's cell, relative to the anchor height; holes in `hole`.
struct CellPosts {
    VF h00, h10, h01, h11;
    MI hole;
};
/// Where a tile's posts are and, of 16-bit ones, what they mean: base + step * (code - first).
struct PostCodes {
    VI offset;  ///< bytes from the middle of the pool
    VI first;
    VF base, step;
};
/// Pairs of 16-bit posts in the two rows of each lane's cell. kNear: lanes often stand in one cell,
/// which needs no gathers then.
struct PostPairs {
    VI row0, row1;
};
template <bool kNear>
HWY_INLINE PostPairs loadPairs(const Pools& pools, VI bytes, MI lanes) {
    const int32_t* posts = reinterpret_cast<const int32_t*>(pools.posts);
    if constexpr (kNear) {
        const int32_t first = hn::GetLane(bytes);
        if (hn::AllTrue(DI(), hn::Eq(bytes, setI(first)))) {
            int32_t pair[2];
            const char* cell = reinterpret_cast<const char*>(posts) + first;
            std::memcpy(&pair[0], cell, sizeof pair[0]);
            std::memcpy(&pair[1], cell + 2 * kPostStride, sizeof pair[1]);
            return {setI(pair[0]), setI(pair[1])};
        }
    }
    const VI inside = inPool(lanes, bytes);
    const VI next = inside + hn::IfThenElseZero(lanes, setI(2 * kPostStride));
    return {hn::GatherOffset(DI(), posts, inside), hn::GatherOffset(DI(), posts, next)};
}

/// At least one of `lanes` is set.
template <bool kInt16, bool kNear = false>
HWY_INLINE CellPosts loadPosts(const Pools& pools, const PostCodes& p, VI cx, VI cy, MI lanes) {
    const VI index = cy * setI(kPostStride) + cx;
    CellPosts c;
    if constexpr (kInt16) {
        const auto [row0, row1] =
            loadPairs<kNear>(pools, p.offset + hn::ShiftLeft<1>(index), lanes);
        const VI low = setI(0xFFFF);
        const VI q00 = hn::And(row0, low), q01 = hn::And(row1, low);
        const VI q10 = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), row0)));
        const VI q11 = hn::BitCast(DI(), hn::ShiftRight<16>(hn::BitCast(DU(), row1)));
        c.hole = hn::Eq(hn::Max(hn::Max(q00, q10), hn::Max(q01, q11)), low);
        c.h00 = hn::MulAdd(p.step, hn::ConvertTo(DF(), q00 - p.first), p.base);
        c.h10 = hn::MulAdd(p.step, hn::ConvertTo(DF(), q10 - p.first), p.base);
        c.h01 = hn::MulAdd(p.step, hn::ConvertTo(DF(), q01 - p.first), p.base);
        c.h11 = hn::MulAdd(p.step, hn::ConvertTo(DF(), q11 - p.first), p.base);
    } else {
        const VI bytes = inPool(lanes, p.offset + hn::ShiftLeft<2>(index));
        const VI next = bytes + hn::IfThenElseZero(lanes, setI(4 * kPostStride));
        const VI one = hn::IfThenElseZero(lanes, setI(4));
        const VF anchor = setF(pools.anchorZ);
        c.h00 = hn::GatherOffset(DF(), pools.posts, bytes) - anchor;
        c.h10 = hn::GatherOffset(DF(), pools.posts, bytes + one) - anchor;
        c.h01 = hn::GatherOffset(DF(), pools.posts, next) - anchor;
        c.h11 = hn::GatherOffset(DF(), pools.posts, next + one) - anchor;
        const VF sum = (c.h00 + c.h10) + (c.h01 + c.h11);
        c.hole = hn::Not(maskI(sum == sum));
    }
    return c;
}

/// One packet: lanes [p, p + N) of a block, with what every step needs in registers.
struct Packet {
    RayBlock& b;
    size_t p;
    VF t, z, dz, bend;
    VI x, y, level;

    HWY_INLINE VF heightAt(VF at) const { return hn::MulAdd(at, hn::MulAdd(bend, at, dz), z); }
};

HWY_INLINE Packet loadPacket(RayBlock& b, size_t p) {
    return {b,
            p,
            loadF(b.t + p),
            loadF(b.z + p),
            loadF(b.dz + p),
            loadF(b.bend + p),
            loadI(b.x + p),
            loadI(b.y + p),
            loadI(b.level + p)};
}

/// Where the ray leaves its block of 2^level cells.
struct BlockExit {
    VF t;
    MI alongX;
    VI x0, y0, last;  ///< block origin; size - 1
    VI nextX, nextY;  ///< the cell entered: across the border set, along it computed and clamped
};

HWY_INLINE VI cellAt(VF fraction, VF step, VF t, VI anchor, VI first, VI last) {
    const VI cell = hn::ConvertTo(DI(), hn::Floor(hn::MulAdd(step, t, fraction))) + anchor;
    return hn::Min(hn::Max(cell, first), first + last);
}

HWY_INLINE BlockExit leaveBlock(const Packet& k) {
    const RayBlock& b = k.b;
    const size_t p = k.p;
    const VF dx = loadF(b.dx + p), dy = loadF(b.dy + p), fx = loadF(b.fx + p), fy = loadF(b.fy + p);
    const VI ax = loadI(b.anchorX + p), ay = loadI(b.anchorY + p);
    const VI one = setI(1);
    const VI size = shiftLeft(one, k.level);
    BlockExit e;
    e.last = size - one;
    e.x0 = hn::AndNot(e.last, k.x);
    e.y0 = hn::AndNot(e.last, k.y);
    const MI forwardX = maskI(dx >= hn::Zero(DF())), forwardY = maskI(dy >= hn::Zero(DF()));
    const VI borderX = e.x0 + hn::IfThenElseZero(forwardX, size);
    const VI borderY = e.y0 + hn::IfThenElseZero(forwardY, size);
    const VF tx = (hn::ConvertTo(DF(), borderX - ax) - fx) * loadF(b.inverseDx + p);
    const VF ty = (hn::ConvertTo(DF(), borderY - ay) - fy) * loadF(b.inverseDy + p);
    e.alongX = maskI(tx <= ty);
    e.t = hn::Max(hn::Min(hn::Min(tx, ty), loadF(b.tEnd + p)), k.t);
    const VI acrossX = borderX - hn::IfThenZeroElse(forwardX, one);
    const VI acrossY = borderY - hn::IfThenZeroElse(forwardY, one);
    e.nextX = select(e.alongX, acrossX, cellAt(fx, dx, e.t, ax, e.x0, e.last));
    e.nextY = select(e.alongX, cellAt(fy, dy, e.t, ay, e.y0, e.last), acrossY);
    return e;
}

/// The ray's lowest and highest point over [k.t, t1]: a convex parabola.
struct HeightRange {
    VF lo, hi, entry;
};
HWY_INLINE HeightRange heightRange(const Packet& k, VF t1) {
    const VF lowest = hn::Min(hn::Max(loadF(k.b.vertex + k.p), k.t), t1);
    const VF entry = k.heightAt(k.t);
    return {k.heightAt(lowest), hn::Max(entry, k.heightAt(t1)), entry};
}

/// Height error of the float ray up to t1, its lattice error on the steepest ground included.
HWY_INLINE VF errorAnywhere(const Packet& k, VF t1) {
    return hn::MulAdd(loadF(k.b.anywhere1 + k.p), t1, loadF(k.b.anywhere0 + k.p));
}
/// Height error of the float ray alone.
HWY_INLINE VF errorOfRay(const Packet& k, VF t1) {
    return hn::MulAdd(loadF(k.b.error1 + k.p), t1, loadF(k.b.error0 + k.p));
}
/// Lattice error of the float ray up to t1, in mip-0 cells.
HWY_INLINE VF shiftAt(const Packet& k, VF t1) {
    return hn::MulAdd(loadF(k.b.shift1 + k.p), t1, setF(kShift0));
}

/// Ends lanes that changed sides of the sheet without a hit (a strip, or a way through a hole):
/// uncertain. Returns the lanes that go on.
HWY_INLINE MI keepSide(Packet& k, MI decided, VI side) {
    const VI old = loadI(k.b.side + k.p);
    const MI conflict = hn::And(decided, (old * side) < hn::Zero(DI()));
    storeI(conflict, setI(kResultUncertain), k.b.result + k.p);
    storeI(conflict, setI(kLaneDone), k.b.state + k.p);
    storeI(decided, side, k.b.side + k.p);
    storeI(hn::And(decided, side < hn::Zero(DI())), setI(1), k.b.below + k.p);
    return hn::AndNot(conflict, decided);
}

/// Moves lanes to the exit of their block; ascends when that leaves a 2 x 2 group and `climb` says
/// that the larger block is worth a try, leaves the tile, or ends.
HWY_INLINE void moveOn(const TerrainCut& cut, Packet& k, MI lanes, const BlockExit& e, MI inTile,
                       MI climb) {
    RayBlock& b = k.b;
    const VI zero = hn::Zero(DI()), one = setI(1);
    const MI outside =
        hn::Or(hn::Or(e.nextX < zero, e.nextY < zero),
               hn::Or(e.nextX > setI(cut.cellsX - 1), e.nextY > setI(cut.cellsY - 1)));
    const MI ended = hn::Or(outside, maskI(e.t >= loadF(b.tEnd + k.p)));
    storeI(hn::And(lanes, ended), setI(kLaneDone), b.state + k.p);
    storeF(lanes, e.t, b.t + k.p);
    storeI(lanes, e.nextX, b.x + k.p);
    storeI(lanes, e.nextY, b.y + k.p);
    const VI changed = hn::Or(hn::Xor(e.nextX, e.x0), hn::Xor(e.nextY, e.y0));
    const MI leftGroup = hn::And(climb, hn::Ne(shiftRight(changed, k.level + one), zero));
    VI level = select(leftGroup, k.level + one, k.level);
    const VI tileLevel = loadI(b.mip + k.p) + setI(kTileLevels);
    const MI leftTile = hn::And(inTile, hn::Ne(shiftRight(changed, tileLevel), zero));
    level = select(leftTile, tileLevel, level);
    level = hn::Min(level, setI(cut.rootLevel + kTileLevels));
    storeI(hn::And(hn::AndNot(ended, lanes), leftTile), setI(kLaneDirectory), b.state + k.p);
    storeI(lanes, level, b.level + k.p);
}

/// Lanes that dip into a block go one level down, first to shortly before they meet `plane`, the
/// block's maximum and the error: as far above it again as the error, so that the cell there can
/// still be told.
HWY_INLINE void goDown(Packet& k, MI lanes, const BlockExit& e, VF entryHeight, VF plane,
                       VF error) {
    RayBlock& b = k.b;
    const VF slope = hn::MulAdd(k.bend + k.bend, k.t, k.dz);
    const VF drop = entryHeight - plane - error;
    const MF dives = hn::And(slope<hn::Zero(DF()), drop> hn::Zero(DF()));
    // Along the tangent the plane is met no later than along the parabola; 0.999 covers the
    // reciprocal.
    const VF ahead = drop * hn::ApproximateReciprocal(hn::Neg(slope)) * setF(0.999f);
    const VF t = hn::Min(hn::IfThenElse(dives, k.t + ahead, k.t), e.t);
    const MI moved = hn::And(lanes, maskI(dives));
    storeF(moved, t, b.t + k.p);
    storeI(moved,
           cellAt(loadF(b.fx + k.p), loadF(b.dx + k.p), t, loadI(b.anchorX + k.p), e.x0, e.last),
           b.x + k.p);
    storeI(moved,
           cellAt(loadF(b.fy + k.p), loadF(b.dy + k.p), t, loadI(b.anchorY + k.p), e.y0, e.last),
           b.y + k.p);
    storeI(lanes, k.level - setI(1), b.level + k.p);
}

}  // namespace terray::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard per target
