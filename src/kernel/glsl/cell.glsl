// SPDX-License-Identifier: Apache-2.0
// A ray in one cell: passed, hit, or not to be told; and where it hits. Part of trace.glsl.

// A cell's posts, relative to the anchor height.
struct CellPosts {
    float h00, h10, h01, h11;
    bool hole;
};

CellPosts loadCell(TraceCut cut, Walk w, int cx, int cy) {
    uint index = uint(cy * kPostStride + cx);
    uint q00 = fetchPost(w.posts, index);
    uint q10 = fetchPost(w.posts, index + 1u);
    uint q01 = fetchPost(w.posts, index + uint(kPostStride));
    uint q11 = fetchPost(w.posts, index + uint(kPostStride) + 1u);
    CellPosts c;
    if (cut.format == kPostsInt16) {
        c.hole = max(max(q00, q10), max(q01, q11)) == 0xFFFFu;
        c.h00 = w.postsZ + w.postsStep * float(q00);
        c.h10 = w.postsZ + w.postsStep * float(q10);
        c.h01 = w.postsZ + w.postsStep * float(q01);
        c.h11 = w.postsZ + w.postsStep * float(q11);
    } else {  // infinite or no number, told by the bits
        uint low = 0x7FFFFFFFu;
        c.hole = max(max(q00 & low, q10 & low), max(q01 & low, q11 & low)) >= 0x7F800000u;
        c.h00 = c.hole ? 0.0f : uintBitsToFloat(q00) - cut.anchorZ;
        c.h10 = c.hole ? 0.0f : uintBitsToFloat(q10) - cut.anchorZ;
        c.h01 = c.hole ? 0.0f : uintBitsToFloat(q01) - cut.anchorZ;
        c.h11 = c.hole ? 0.0f : uintBitsToFloat(q11) - cut.anchorZ;
    }
    return c;
}

// A ray in a cell's own coordinates, s counted from where it enters.
struct CellRay {
    float u, v, du, dv;  // place at s = 0 and steps, in cells of its mip
    float z, slope, bend;
    float exit;  // s at which it leaves the cell
    float shift;  // lattice error, in cells of its mip
    float error;  // of f
};

// What is known of a ray that has come through the first parts of a cell.
struct CellVerdict {
    int result;    // kWalkGoesOn: it passes
    int side;      // of the sheet, 0 before the first part
    float clears;  // least distance to the sheet
    bool wall;     // it hits a wall of constant quadrants
    float s;       // of the hit's part or wall: from, and up to
    float end;
    float unclear;  // how far s or the part's ends may be off
    LeafQuadratic q;
};

CellVerdict noVerdict() {
    CellVerdict c;
    c.result = kWalkGoesOn;
    c.side = 0;
    c.clears = 1e30f;
    c.wall = false;
    c.s = 0.0f;
    c.end = 0.0f;
    c.unclear = 0.0f;
    c.q.f0 = 0.0f;
    c.q.f1 = 0.0f;
    c.q.f2 = 0.0f;
    return c;
}

// The next part of the way, where f is q from s = from to s = to, both known but for `early`, `late`.
CellVerdict joinPart(CellVerdict c, LeafQuadratic q, float from, float to, float early, float late,
                     float exit, float error) {
    if (c.result != kWalkGoesOn) return c;
    float a = max(from - early, 0.0f);
    float b = min(to + late, exit);
    float begin = leafAt(q, a);
    float end = leafAt(q, b);
    float least = min(begin, end);
    float greatest = max(begin, end);
    if ((q.f1 + 2.0f * q.f2 * a) * (q.f1 + 2.0f * q.f2 * b) < 0.0f) {
        float turn = leafAt(q, clamp(q.f1 / (-2.0f * q.f2), a, b));
        least = min(least, turn);
        greatest = max(greatest, turn);
    }
    int side = begin > error ? 1 : (begin < -error ? -1 : 0);
    bool passes = (side > 0 && least > error) || (side < 0 && greatest < -error);
    bool crosses = (side > 0 && least < -error) || (side < 0 && greatest > error);
    if (c.side > 0 && side < 0) {  // from above into a wall, wherever it stands exactly
        c.result = leafAt(q, min(from + early, exit)) < -error ? kWalkHits : kWalkUnsure;
        c.wall = true;
        c.s = from;
        c.end = from;
        c.unclear = early;
        return c;
    }
    if (c.side * side < 0 || !(passes || crosses)) {
        c.result = kWalkUnsure;
        return c;
    }
    c.side = side;
    c.clears = min(c.clears, side > 0 ? least : -greatest);
    if (crosses) {
        c.result = kWalkHits;
        c.s = from + early;
        c.end = to - late;
        c.q = q;
    }
    return c;
}

CellVerdict throughBilinear(CellPosts h, CellRay r) {
    LeafQuadratic q = leafBilinear(h.h00, h.h10, h.h01, h.h11, r.u, r.v, r.du, r.dv, r.z, r.slope,
                                   r.bend);
    return joinPart(noVerdict(), q, 0.0f, r.exit, 0.0f, 0.0f, r.exit, r.error);
}

// Two triangles: the lower one's plane, and above the diagonal d (u + v - 1) on top of it. A diagonal
// that is off by a rounding moves f by no more than d times that, which the error holds.
CellVerdict throughTriangles(CellPosts h, CellRay r) {
    float b = h.h10 - h.h00;
    float c = h.h01 - h.h00;
    float d = (h.h11 - h.h01) - b;
    float beyond = (r.u + r.v) - 1.0f;
    float rate = r.du + r.dv;
    LeafQuadratic lower;
    lower.f0 = r.z - (h.h00 + b * r.u + c * r.v);
    lower.f1 = r.slope - (b * r.du + c * r.dv);
    lower.f2 = r.bend;
    LeafQuadratic upper = lower;
    upper.f0 = lower.f0 - d * beyond;
    upper.f1 = lower.f1 - d * rate;
    float meets = abs(rate) > 1e-20f ? clamp(-beyond / rate, 0.0f, r.exit) : 0.0f;
    CellVerdict v = noVerdict();
    bool upperLast;
    if (meets > 0.0f && meets < r.exit) {
        upperLast = rate > 0.0f;
        LeafQuadratic first = lower;
        if (!upperLast) first = upper;
        v = joinPart(v, first, 0.0f, meets, 0.0f, 0.0f, r.exit, r.error);
    } else {
        upperLast = beyond + rate * (0.5f * r.exit) > 0.0f;
        meets = 0.0f;
    }
    LeafQuadratic last = lower;
    if (upperLast) last = upper;
    return joinPart(v, last, meets, r.exit, 0.0f, 0.0f, r.exit, r.error);
}

// The quadrant in which the ray is after s: by the order of the crossings su and sv.
float quadrantHeight(CellPosts h, CellRay r, float su, float sv, float s) {
    bool right = abs(r.du) > 1e-20f ? (r.du > 0.0f) == (su <= s) : r.u >= 0.5f;
    bool upper = abs(r.dv) > 1e-20f ? (r.dv > 0.0f) == (sv <= s) : r.v >= 0.5f;
    return upper ? (right ? h.h11 : h.h01) : (right ? h.h10 : h.h00);
}

// Nearest post: up to three quadrants in the order of the ray; f jumps between them (walls).
CellVerdict throughConstant(CellPosts h, CellRay r) {
    float near = 2.0f * r.shift;
    float su = abs(r.du) > 1e-20f ? (0.5f - r.u) / r.du : 1e30f;
    float sv = abs(r.dv) > 1e-20f ? (0.5f - r.v) / r.dv : 1e30f;
    float unclearU = abs(r.du) > 1e-20f ? near / abs(r.du) : 0.0f;
    float unclearV = abs(r.dv) > 1e-20f ? near / abs(r.dv) : 0.0f;
    float first = clamp(min(su, sv), 0.0f, r.exit);
    float second = clamp(max(su, sv), 0.0f, r.exit);
    float unclear1 = su <= sv ? unclearU : unclearV;
    float unclear2 = su <= sv ? unclearV : unclearU;
    CellVerdict c = noVerdict();
    // Near a corner of quadrants, or entering or leaving along their border, the order cannot be told.
    bool corner = abs(su - sv) <= unclearU + unclearV && min(su, sv) < 1e30f;
    bool enters = abs(r.u - 0.5f) < near || abs(r.v - 0.5f) < near;
    bool leaves = abs(r.u + r.du * r.exit - 0.5f) < near || abs(r.v + r.dv * r.exit - 0.5f) < near;
    if (corner || enters || leaves) {
        c.result = kWalkUnsure;
        return c;
    }
    LeafQuadratic q;
    q.f1 = r.slope;
    q.f2 = r.bend;
    if (first > 0.0f) {
        q.f0 = r.z - quadrantHeight(h, r, su, sv, 0.0f);
        c = joinPart(c, q, 0.0f, first, 0.0f, first < r.exit ? unclear1 : 0.0f, r.exit, r.error);
    }
    if (second > first) {
        q.f0 = r.z - quadrantHeight(h, r, su, sv, first);
        c = joinPart(c, q, first, second, first > 0.0f ? unclear1 : 0.0f,
                     second < r.exit ? unclear2 : 0.0f, r.exit, r.error);
    }
    if (r.exit > second || r.exit <= 0.0f) {
        q.f0 = r.z - quadrantHeight(h, r, su, sv, second);
        c = joinPart(c, q, second, r.exit, second > 0.0f ? unclear2 : 0.0f, 0.0f, r.exit, r.error);
    }
    return c;
}

// The first root of q, where f leaves c.side. The exact root is at most 1.5 E / R away, E being how far f
// may be from the exact f around there and R its slope: f at the root found is within E / 4, so where
// 9 |f2| E <= R^2, f is beyond E on either side of those 1.5 E / R.
struct PlacedRoot {
    float s, steep;  // steep: R, 0 if there is no such root
};
PlacedRoot placeRoot(CellVerdict c, float tight, float error) {
    float side = float(c.side);
    float root = sqrt(max(c.q.f1 * c.q.f1 - 4.0f * c.q.f2 * c.q.f0, 0.0f));
    bool rises = side * c.q.f1 > 0.0f;  // away from the sheet first
    float above = rises ? c.q.f1 + side * root : 2.0f * c.q.f0;
    float below = rises ? -2.0f * c.q.f2 : side * root - c.q.f1;
    PlacedRoot r;
    r.s = abs(below) > 1e-30f ? above / below : c.s;
    float slope = c.q.f1 + 2.0f * c.q.f2 * r.s;
    if (abs(slope) > 1e-30f) r.s -= leafAt(c.q, r.s) / slope;  // undoes roundings of root and quotient
    r.steep = -side * (c.q.f1 + 2.0f * c.q.f2 * r.s);
    bool placed = r.steep > 1e-20f && abs(leafAt(c.q, r.s)) <= 0.25f * tight &&
                  9.0f * abs(c.q.f2) * error <= r.steep * r.steep;
    if (!placed) r.steep = 0.0f;
    return r;
}

// Keeps a place on its own side of the quadrants' borders.
float keepHalf(float place, bool upper) { return upper ? max(place, 0.5f) : min(place, 0.49999997f); }

// Where it hits, and whether that is as near to the exact place as promised, in the same cell for certain.
// r.error holds for rays that may be in the next cell, the tight one for a place inside this one.
Walk placeHit(TraceCut cut, TraceRay ray, Walk w, CellPosts h, CellRay r, CellVerdict c) {
    float inverse = intBitsToFloat((127 - w.mip) << 23);
    float end = w.t + r.exit;
    float errorU = (w.placeError + w.placeErrorX * end) * inverse + 2.0f * kUlp;
    float errorV = (w.placeError + w.placeErrorY * end) * inverse + 2.0f * kUlp;
    float tight = w.error0 + w.error1 * end;
    if (cut.surface != kSurfaceConstant) {
        float slopeU = max(abs(h.h10 - h.h00), abs(h.h11 - h.h01));
        float slopeV = max(abs(h.h01 - h.h00), abs(h.h11 - h.h10));
        tight += slopeU * (errorU + 8.0f * kUlp) + slopeV * (errorV + 8.0f * kUlp);
    }
    PlacedRoot root;
    root.s = c.s;
    root.steep = 0.0f;
    float within = c.unclear;  // how far the exact hit may be along the ray
    float around = c.unclear;  // and where the ray must be in this cell
    float promised = max(1e-3f, 1e-5f * (ray.begin + w.t + root.s));
    bool placed = c.wall;
    if (!c.wall) {
        root = placeRoot(c, tight, r.error);
        placed = root.steep > 0.0f;
        float perSteep = placed ? 1.0f / root.steep : 0.0f;
        within = 1.5f * tight * perSteep;
        around = 1.5f * r.error * perSteep;
        promised = max(promised, 2.0f * cut.zRounding * perSteep);
    }
    float s = clamp(root.s, 0.0f, r.exit);
    float u = r.u + r.du * s;
    float v = r.v + r.dv * s;
    // The rest of what is promised is for roundings of t.
    placed = placed && within <= 0.9f * promised;
    float marginU = errorU + abs(r.du) * around;
    float marginV = errorV + abs(r.dv) * around;
    placed = placed && min(u, 1.0f - u) > marginU && min(v, 1.0f - v) > marginV;
    // Beyond the part's ends f is another one.
    bool inPart = root.s > c.s + around && root.s < c.end - around;
    placed = placed && (inPart || c.wall || cut.surface == kSurfaceBilinear);
    if (cut.surface == kSurfaceConstant) {
        bool clearU = abs(u - 0.5f) > marginU;
        bool clearV = abs(v - 0.5f) > marginV;
        placed = placed && (c.wall ? clearU || clearV : clearU && clearV);
        if (c.wall && !clearU) u = keepHalf(u, r.du > 0.0f);
        if (c.wall && !clearV) v = keepHalf(v, r.dv > 0.0f);
    }
    w.t += s;
    w.u = clamp(u, 0.0f, 1.0f);
    w.v = clamp(v, 0.0f, 1.0f);
    w.hitFlags = kHitValid | (c.side < 0 ? kHitFromBelow : 0u) | (c.wall ? kHitStrip : 0u) |
                 (placed ? 0u : kHitPlaceOpen);
    return w;
}

// Tests the cell in which the ray stands.
Walk stepCell(TraceCut cut, TraceRay ray, Walk w) {
    w.steps += 1;
    if (w.steps > cut.maxSteps) {
        w.result = kWalkUnsure;
        return w;
    }
    int cx = (w.x >> w.mip) & (kSlotCells - 1);
    int cy = (w.y >> w.mip) & (kSlotCells - 1);
    CellPosts h = loadCell(cut, w, cx, cy);
    BlockExit e = leaveBlock(ray, w);
    if (h.hole) {
        w.side = 0;
        return moveOn(cut, ray, w, e, true);
    }
    float inverse = intBitsToFloat((127 - w.mip) << 23);  // 2^-mip
    CellRay r;
    r.u = (ray.dx * w.t - (float(e.x0 - ray.anchorX) - ray.fx)) * inverse;
    r.v = (ray.dy * w.t - (float(e.y0 - ray.anchorY) - ray.fy)) * inverse;
    r.du = ray.dx * inverse;
    r.dv = ray.dy * inverse;
    r.z = rayHeight(ray, w.t);
    r.slope = ray.dz + 2.0f * ray.bend * w.t;
    r.bend = ray.bend;
    r.exit = e.t - w.t;
    r.shift = (w.shift0 + w.shift1 * e.t) * inverse;
    // Cells at the tile's rim have neighbours in other tiles: their slope may be anyone's.
    bool rim = cx == 0 || cy == 0 || cx == kSlotCells - 1 || cy == kSlotCells - 1;
    float delta = rim ? cut.maxDelta : w.tileDelta;
    r.error = (w.error0 + w.error1 * e.t) + delta * (2.0f * r.shift + 8.0f * kUlp);
    CellVerdict c;
    if (cut.surface == kSurfaceBilinear)
        c = throughBilinear(h, r);
    else if (cut.surface == kSurfaceConstant)
        c = throughConstant(h, r);
    else
        c = throughTriangles(h, r);
    if (c.result == kWalkUnsure) {
        w.result = kWalkUnsure;
        return w;
    }
    w = keepSide(w, c.side);
    if (c.result == kWalkHits) {
        if (w.result == kWalkGoesOn) w.result = kWalkHits;
        return placeHit(cut, ray, w, h, r, c);
    }
    return moveOn(cut, ray, w, e, c.clears > abs(h.h11 - h.h00));
}
