// SPDX-License-Identifier: Apache-2.0
// ray_cast: one ray an invocation, 8 x 8 pixels a work group, over tables in buffers and tiles behind addresses.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

#include "kernel/glsl/layout.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kFormat = 0;
layout(constant_id = 1) const uint kSurface = 0;

layout(std430, binding = 0) readonly buffer Cut { TraceCut cut; DirectoryLevel levels[]; };
layout(std430, binding = 1) readonly buffer Squares { Square squares[]; };
layout(std430, binding = 2) readonly buffer Tiles { TileDesc tiles[]; };
layout(std430, binding = 3) readonly buffer Rays { TraceRay rays[]; };
layout(std430, binding = 4) writeonly buffer Hits { TraceHit hits[]; };
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Words { uint words[]; };

DirectoryLevel fetchLevel(int level) { return levels[level]; }
Square fetchSquare(uint index) { return squares[index]; }
TileDesc fetchTile(uint slot) { return tiles[slot]; }
uint fetchBounds(Address bounds, uint index) {
    return Words(uvec2(bounds.low, bounds.high)).words[index];
}
uint fetchPost(Address posts, uint index) {
    Words w = Words(uvec2(posts.low, posts.high));
    if (kFormat == kPostsFloat) return w.words[index];
    return (w.words[index >> 1] >> ((index & 1u) << 4)) & 0xFFFFu;
}

#include "kernel/glsl/trace.glsl"

void main() {
    const uint k = gl_GlobalInvocationID.x;
    TraceCut c = cut;
    c.format = kFormat;
    c.surface = kSurface;
    hits[k] = traceRay(c, rays[k], RaySlack(0, 0, 0, 0));
}
