#version 460
// Pushes the caster's segment at the head of the texel's list. Source: seed 000 (capturing fragments).
// Inputs: map, casters. Outputs: heads, segments, the count of fragments.
// Invariant: `fragments` counts the whole demand, also past the capacity, so that the caller can grow the buffer.
#include "list/segments.glsl"
#include "list/texel_segment.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 1, binding = 0, r32ui) uniform uimage2D heads;
layout(set = 1, binding = 1, scalar) writeonly buffer Segments { Segment segments[]; };
layout(set = 1, binding = 2, scalar) buffer Counters { uint fragments[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uint order_first;
    uint counter;    // which of `fragments`
    uint first_row;  // of the map among the heads
    uint capacity;
};

layout(location = 0) flat in uint caster_index;

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy);
    vec2 depth;
    float optical_depth;
    if (!texel_segment(maps[map].volume, texel, casters[caster_index], depth, optical_depth)) {
        return;
    }
    uint index = atomicAdd(fragments[counter], 1u);
    if (index < capacity) {
        uint next = imageAtomicExchange(heads, ivec2(texel) + ivec2(0, first_row), index);
        segments[index] = Segment(depth.x, depth.y, optical_depth, caster_index, next);
    }
}
