// SPDX-License-Identifier: Apache-2.0
// A stub shader: the traversal must compile, with heights in one storage buffer.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "kernel/glsl/layout.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kFormat = 0;
layout(constant_id = 1) const uint kSurface = 0;
layout(std430, binding = 0) readonly buffer Cut { TraceCut cut; DirectoryLevel levels[]; };
layout(std430, binding = 1) readonly buffer Squares { Square squares[]; };
layout(std430, binding = 2) readonly buffer Tiles { TileDesc tiles[]; };
layout(std430, binding = 3) readonly buffer Bounds { uint allBounds[]; };
layout(std430, binding = 4) readonly buffer Posts { uint allPosts[]; };
layout(std430, binding = 5) readonly buffer Rays { TraceRay rays[]; };
layout(std430, binding = 6) writeonly buffer Hits { TraceHit hits[]; };

DirectoryLevel fetchLevel(int level) { return levels[level]; }
Square fetchSquare(uint index) { return squares[index]; }
TileDesc fetchTile(uint slot) { return tiles[slot]; }
uint fetchBounds(Address bounds, uint index) { return allBounds[bounds.low + index]; }
uint fetchPost(Address posts, uint index) {
    uint at = posts.low + index;
    if (kFormat == kPostsFloat) return allPosts[at];
    return (allPosts[at >> 1] >> ((at & 1) << 4)) & 0xFFFFu;
}

#include "kernel/glsl/trace.glsl"

void main() {
    uint k = gl_GlobalInvocationID.x;
    if (k >= rays.length()) return;
    TraceCut c = cut;
    c.format = kFormat;
    c.surface = kSurface;
    hits[k] = traceRay(c, rays[k], RaySlack(0, 0, 0, 0));
}
