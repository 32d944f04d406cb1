#version 460
// Pushes the caster's segment onto the head of the texel's list. Source: Fife and Strugar 2013, Capturing fragments.
// Inputs: maps, casters. Outputs: heads, segments, the count of fragments. Invariant: the count is the full demand, even beyond
// the capacity, so that the caller can grow the buffer.
#define QUADS_FRAGMENT
#include "maps/list/segments.glsl"
#include "maps/caster_quads.glsl"

// set 2: list
layout(set = 2, binding = 0, r32ui) uniform uimage2D heads;
layout(set = 2, binding = 1, std430) writeonly buffer Segments { uvec4 segments[]; };
// See maps/list/segments.glsl; `group`: index of the group of maps that are captured together.
layout(set = 2, binding = 2, scalar) buffer Counters { uint counters[]; };

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (!quad_segment(view, depth, optical_depth)) {
        return;
    }
    uint index = atomicAdd(counters[FRAGMENTS + group], 1u);
    if (index < capacity) {
        uint next = imageAtomicExchange(heads, ivec2(gl_FragCoord.xy), index);
        segments[index] = segment_words(Segment(depth.x, depth.y, optical_depth, next));
    }
}
