// SPDX-License-Identifier: Apache-2.0
// kernel/layout/layout.h for shaders, and what goes into and out of a trace on a device. Common to
// GLSL and C++ (kernel/glsl/cpp.h): 4-byte members only, so std430, scalar layout and C++ agree.
// Sizes and offsets are checked in kernel/device_rays.cpp.

const int kSlotCells = 512;
const int kPostStride = 520;
const int kTileLevels = 9;
const int kSlotBounds = 87381;
const uint kTileMipMask = 0xFFu;
const uint kNoSlot = 0xFFFFFFFFu;

const uint kSquareEmpty = 0u;
const uint kSquareDrawn = 1u;
const uint kSquareDescend = 2u;
const uint kSquareCovered = 3u;

const uint kSurfaceBilinear = 0u;
const uint kSurfaceConstant = 1u;
const uint kSurfaceTriangles = 2u;

const uint kPostsInt16 = 0u;
const uint kPostsFloat = 1u;

// A 64-bit number of the host: an element's index in its pool, or whatever the includer's fetch
// functions make of it (a device address, a page and an index).
struct Address {
    uint low, high;
};

struct TileDesc {
    Address posts, bounds;
    int x, y;
    float z0, zStep;
    float boundsZ0, boundsStep;
    float maxDelta;
    uint mipFlags;
    uint reserved0, reserved1;
};

struct Square {
    float minZ, maxZ;
    uint slot;
    uint state;
};

struct DirectoryLevel {
    uint offset;
    uint columns, rows;
};

// What is the same for all rays of a frame (traceCutOf in kernel/device_rays.h).
struct TraceCut {
    uint format, surface;
    int rootLevel;
    int cellsX, cellsY;
    float anchorZ;    // heights of rays are relative to it
    float reach;      // largest height met, relative to anchorZ
    float maxDelta;   // largest difference of neighbouring posts
    float postError;  // of decoded posts, besides the roundings relative to reach
    float zRounding;  // of heights, 2^-23 of the largest
    int maxSteps;     // a ray that takes more is uncertain
};

// A float ray: relative to a cell and to anchorZ, t from the begin of its clipped part
// (docs/precision.md). Steps and heights as in Ray.
struct TraceRay {
    int anchorX, anchorY;  // mip-0 cell in which it begins
    float fx, fy;          // place in it, below 1
    float dx, dy, z, dz, bend;
    float tEnd;   // negative: nothing of the ray can hit
    float begin;  // t of the whole ray where the clipped part begins, for tolerances only
    int level;    // block size at which to begin, 63 without a head start (kernel/beam.h)
};

// How far the true ray may be from a TraceRay at t, beyond the roundings of its fields: place in
// mip-0 cells and height in metres. All 0 for rays placed on the host.
struct RaySlack {
    float place, placePerT;
    float height, heightPerT;
};

// The bits of Hit (kernel/layout/layout.h), but t counts from the begin of the clipped part.
struct TraceHit {
    float t;
    uint tile;
    uint cell;
    float u, v;
    uint stepsMipFlags;  // steps | mip << 16 | flags << 24
};

// Flags: those of HitFlags, and three that the host takes away (finishTraceHits). None: a certain miss.
const uint kHitValid = 1u;
const uint kHitFromBelow = 2u;
const uint kHitStrip = 4u;
const uint kHitUnderSheet = 32u;  // the ray was under the sheet somewhere
const uint kHitPlaceOpen = 64u;   // with kHitValid: t, u, v, or which side of an edge, are not good enough
const uint kHitUncertain = 128u;  // without kHitValid: neither hit nor miss is certain

// ---- Of the walk (trace.glsl) alone

// One rounding to either neighbour, relative. docs/precision.md counts them.
const float kUlp = 1.2e-7f;

const int kWalkGoesOn = 0;
const int kWalkMisses = 1;
const int kWalkHits = 2;
const int kWalkUnsure = 3;

const int kEnterAtTop = 63;
