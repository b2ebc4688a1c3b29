// SPDX-License-Identifier: Apache-2.0
// A shader of the device room's tests: the sum of every 64 numbers, and a word behind an address.
#version 460
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Numbers { uint numbers[]; };
layout(std430, binding = 1) writeonly buffer Sums { uint sums[]; };
layout(buffer_reference, std430) readonly buffer Words { uint words[]; };
layout(push_constant) uniform Constants { uvec2 address; uint count; };

shared uint part[64];

void main() {
    const uint me = gl_LocalInvocationID.x;
    part[me] = gl_GlobalInvocationID.x < count ? numbers[gl_GlobalInvocationID.x] : 0u;
    barrier();
    for (uint span = 32u; span > 0u; span /= 2u) {
        if (me < span) part[me] += part[me + span];
        barrier();
    }
    if (me == 0u) sums[gl_WorkGroupID.x] = part[0] + Words(address).words[gl_WorkGroupID.x % 4u];
}
