// SPDX-License-Identifier: Apache-2.0
// A ray's way over the directory and the pyramids of tiles: where it stands, where it leaves its
// block, and where it goes next. Part of trace.glsl.

struct Walk {
    // the ray: what follows from its fields
    float inverseDx, inverseDy;
    float vertex;  // t of its lowest point
    float error0, error1;  // height error up to t: error0 + error1 t
    float shift0, shift1;  // lattice error at borders of cells, mip-0 cells
    float placeError, placeErrorX, placeErrorY;  // of a place, along x: placeError + placeErrorX t
    // where it stands
    float t;
    int x, y;   // mip-0 cell
    int level;  // block of 2^level mip-0 cells a side
    int entryLevel;
    int side;    // of the sheet, on which it last was for certain: 1 above, -1 under, 0 unknown
    bool under;  // it was under the sheet somewhere
    int steps;
    int result;
    // the tile it stands in; mip -1 in the directory
    int mip;
    uint slot;
    Address posts, bounds;
    float postsZ, postsStep, boundsZ, boundsStep;  // relative to the anchor height
    float tileDelta;
    // its hit
    float u, v;
    uint hitFlags;
};

float rayHeight(TraceRay ray, float t) { return ray.z + t * (ray.dz + ray.bend * t); }

// Height error up to t, its lattice error on the steepest ground included.
float errorAnywhere(TraceCut cut, Walk w, float t) {
    return (w.error0 + w.error1 * t) + 2.0f * cut.maxDelta * (w.shift0 + w.shift1 * t);
}

Walk beginWalk(TraceCut cut, TraceRay ray, RaySlack slack) {
    Walk w;
    w.inverseDx = ray.dx != 0.0f ? 1.0f / ray.dx : 1e30f;
    w.inverseDy = ray.dy != 0.0f ? 1.0f / ray.dy : 1e30f;
    w.vertex = ray.bend > 1e-30f ? clamp(-ray.dz / (2.0f * ray.bend), -1e30f, 1e30f)
                                 : (ray.dz < 0.0f ? 1e30f : -1e30f);
    float steepest = abs(ray.dz) + 2.0f * ray.bend * ray.tEnd;
    w.error0 = kUlp * (7.0f * cut.reach + 2.5f * abs(ray.z)) + cut.postError + slack.height;
    w.error1 = 4.0f * kUlp * steepest + slack.heightPerT;
    w.shift0 = 4.0f * kUlp + 3.0f * slack.place;
    w.shift1 = 7.0f * kUlp * (abs(ray.dx) + abs(ray.dy)) + 3.0f * slack.placePerT;
    w.placeError = 3.0f * kUlp + slack.place;
    w.placeErrorX = 3.0f * kUlp * abs(ray.dx) + slack.placePerT;
    w.placeErrorY = 3.0f * kUlp * abs(ray.dy) + slack.placePerT;
    w.t = 0.0f;
    w.x = ray.anchorX;
    w.y = ray.anchorY;
    w.level = min(max(cut.rootLevel - 1, 0) + kTileLevels, max(ray.level, kTileLevels));
    w.entryLevel = ray.level;
    w.side = 0;
    w.under = false;
    w.steps = 0;
    w.result = ray.tEnd >= 0.0f ? kWalkGoesOn : kWalkMisses;
    w.mip = -1;
    w.slot = 0u;
    w.posts.low = 0u;
    w.posts.high = 0u;
    w.bounds = w.posts;
    w.postsZ = 0.0f;
    w.postsStep = 0.0f;
    w.boundsZ = 0.0f;
    w.boundsStep = 0.0f;
    w.tileDelta = 0.0f;
    w.u = 0.0f;
    w.v = 0.0f;
    w.hitFlags = 0u;
    return w;
}

// Where the ray leaves its block: at t, into the cell (nextX, nextY), which is set across the border
// and computed and clamped along it. x0, y0: the block's origin; last: its size less 1.
struct BlockExit {
    float t;
    int x0, y0, last;
    int nextX, nextY;
};

int cellAt(float fraction, float step, float t, int anchor, int first, int last) {
    return clamp(int(floor(fraction + step * t)) + anchor, first, first + last);
}

BlockExit leaveBlock(TraceRay ray, Walk w) {
    int size = 1 << w.level;
    BlockExit e;
    e.last = size - 1;
    e.x0 = w.x & ~e.last;
    e.y0 = w.y & ~e.last;
    int borderX = e.x0 + (ray.dx >= 0.0f ? size : 0);
    int borderY = e.y0 + (ray.dy >= 0.0f ? size : 0);
    float tx = (float(borderX - ray.anchorX) - ray.fx) * w.inverseDx;
    float ty = (float(borderY - ray.anchorY) - ray.fy) * w.inverseDy;
    e.t = max(min(min(tx, ty), ray.tEnd), w.t);
    int alongX = cellAt(ray.fx, ray.dx, e.t, ray.anchorX, e.x0, e.last);
    int alongY = cellAt(ray.fy, ray.dy, e.t, ray.anchorY, e.y0, e.last);
    e.nextX = tx <= ty ? borderX - (ray.dx >= 0.0f ? 0 : 1) : alongX;
    e.nextY = tx <= ty ? alongY : borderY - (ray.dy >= 0.0f ? 0 : 1);
    return e;
}

// Takes note of the side of the sheet. A ray that has changed sides without a hit went through a
// strip: unsure.
Walk keepSide(Walk w, int side) {
    if (w.side * side < 0) w.result = kWalkUnsure;
    w.side = side;
    w.under = w.under || side < 0;
    return w;
}

// Moves to the exit of the block; ascends when that leaves a 2 x 2 group and `climb` says that the
// larger block is worth a try, leaves the tile, or ends.
Walk moveOn(TraceCut cut, TraceRay ray, Walk w, BlockExit e, bool climb) {
    bool outside =
        e.nextX < 0 || e.nextY < 0 || e.nextX >= cut.cellsX || e.nextY >= cut.cellsY;
    if (w.result == kWalkGoesOn && (outside || e.t >= ray.tEnd)) w.result = kWalkMisses;
    w.t = e.t;
    w.x = e.nextX;
    w.y = e.nextY;
    int changed = (e.nextX ^ e.x0) | (e.nextY ^ e.y0);
    if (climb && (changed >> (w.level + 1)) != 0) w.level += 1;
    int tileLevel = w.mip + kTileLevels;
    if (w.mip >= 0 && (changed >> tileLevel) != 0) {
        w.level = tileLevel;
        w.mip = -1;
    }
    w.level = min(w.level, cut.rootLevel + kTileLevels);
    return w;
}

// Goes one level down into a block, first to shortly before the ray meets `plane`, the block's
// maximum and the error: as far above it again as the error, so that the cell there can still be
// told. Along the tangent the plane is met no later than along the parabola; 0.999 covers the
// roundings.
Walk goDown(TraceRay ray, Walk w, BlockExit e, float entryHeight, float plane, float error) {
    float slope = ray.dz + 2.0f * ray.bend * w.t;
    float drop = entryHeight - plane - error;
    if (slope < 0.0f && drop > 0.0f) {
        w.t = min(w.t + drop / -slope * 0.999f, e.t);
        w.x = cellAt(ray.fx, ray.dx, w.t, ray.anchorX, e.x0, e.last);
        w.y = cellAt(ray.fy, ray.dy, w.t, ray.anchorY, e.y0, e.last);
    }
    w.level -= 1;
    return w;
}

// Enters the tile that a square draws: one below the whole tile, or as deep as a head start has
// shown to be of use.
Walk enterTile(TraceCut cut, Walk w, uint slot) {
    TileDesc tile = fetchTile(slot);
    w.slot = slot;
    w.mip = int(tile.mipFlags & kTileMipMask);
    w.posts = tile.posts;
    w.bounds = tile.bounds;
    w.postsZ = tile.z0 - cut.anchorZ;
    w.postsStep = tile.zStep;
    w.boundsZ = tile.boundsZ0 - cut.anchorZ;
    w.boundsStep = tile.boundsStep;
    w.tileDelta = tile.maxDelta;
    w.level = max(min(w.entryLevel, w.mip + kTileLevels - 1), w.mip + 1);
    w.entryLevel = kEnterAtTop;
    return w;
}

// What a block holds: heights relative to the anchor, and what to do there.
struct Block {
    float bottom, top;
    uint state, slot;
};

Block blockOfDirectory(TraceCut cut, Walk w) {
    DirectoryLevel level = fetchLevel(w.level - kTileLevels);
    Square square = fetchSquare(level.offset + uint(w.y >> w.level) * level.columns +
                                uint(w.x >> w.level));
    Block b;
    b.bottom = square.minZ - cut.anchorZ;
    b.top = square.maxZ - cut.anchorZ;
    b.state = square.state;
    b.slot = square.slot;
    return b;
}

// Entries before the one of a level: 87381 - (4^(10 - inner) - 1) / 3, whose binary digits are 0101...
Block blockOfTile(Walk w) {
    int inner = w.level - w.mip;
    int log2Side = kTileLevels - inner;
    int sideMask = (1 << log2Side) - 1;
    int offset = kSlotBounds - (((1 << (20 - 2 * inner)) - 1) & 0x55555555);
    int row = (w.y >> w.level) & sideMask;
    int column = (w.x >> w.level) & sideMask;
    uint code = fetchBounds(w.bounds, uint(offset + (row << log2Side) + column));
    uint low = code & 0xFFFFu;
    uint high = code >> 16;
    Block b;
    b.bottom = w.boundsZ + w.boundsStep * float(low);
    b.top = w.boundsZ + w.boundsStep * float(high);
    b.state = low > high ? kSquareEmpty : kSquareDescend;
    b.slot = 0u;
    return b;
}

// What a step finds at a block that stands in the way.
struct Step {
    Walk w;
    bool meets;  // the ray may meet what is in the block: e, entry, plane and error say how
    BlockExit e;
    float entry, plane, error;
};

Step stepOver(TraceCut cut, TraceRay ray, Walk w, Block b, bool inDirectory) {
    Step s;
    s.e = leaveBlock(ray, w);
    s.error = errorAnywhere(cut, w, s.e.t);
    s.entry = rayHeight(ray, w.t);
    s.plane = b.top + s.error;
    float lowest = rayHeight(ray, clamp(w.vertex, w.t, s.e.t));
    float highest = max(s.entry, rayHeight(ray, s.e.t));
    bool nothing = b.state == kSquareEmpty;
    bool above = lowest > s.plane;
    s.meets = !(nothing || above || highest < b.bottom - s.error);
    if (!s.meets) {
        // A ray that clears this block by less than the block's own relief rarely clears its parent.
        float relief = b.top - b.bottom;
        float clears = max(lowest - s.plane, (b.bottom - s.error) - highest);
        bool climb = inDirectory || nothing || clears > relief + 2.0f * s.error;
        w = keepSide(w, nothing ? 0 : (above ? 1 : -1));
        w = moveOn(cut, ray, w, s.e, climb);
    }
    s.w = w;
    return s;
}

// One step over a square of the directory.
Walk stepSquare(TraceCut cut, TraceRay ray, Walk w) {
    w.steps += 1;
    if (w.steps > cut.maxSteps) {
        w.result = kWalkUnsure;
        return w;
    }
    Block b = blockOfDirectory(cut, w);
    if (b.state == kSquareCovered) {
        w.level += 1;
        return w;
    }
    Step s = stepOver(cut, ray, w, b, true);
    w = s.w;
    if (s.meets) {
        if (b.state == kSquareDrawn)
            w = enterTile(cut, w, b.slot);
        else
            w = goDown(ray, w, s.e, s.entry, s.plane, s.error);
    }
    return w;
}

// One step over a block of a tile's pyramid.
Walk stepBlock(TraceCut cut, TraceRay ray, Walk w) {
    w.steps += 1;
    if (w.steps > cut.maxSteps) {
        w.result = kWalkUnsure;
        return w;
    }
    Step s = stepOver(cut, ray, w, blockOfTile(w), false);
    w = s.w;
    if (s.meets) w = goDown(ray, w, s.e, s.entry, s.plane, s.error);
    return w;
}
