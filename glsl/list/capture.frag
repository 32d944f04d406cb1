#version 460
// Pushes the caster's segment at the head of the texel's list. Source: Fife and Strugar 2013, Capturing fragments.
// Inputs: maps, casters. Outputs: heads, segments, the count of fragments.
// Invariant: `fragments` counts the whole demand, also past the capacity, so that the caller can grow the buffer.
#define SPLAT_FRAGMENT
#include "list/segments.glsl"
#include "maps/scene.glsl"
#include "maps/segment.glsl"
#include "maps/splat.glsl"

layout(set = 2, binding = 0, r32ui) uniform uimage2D heads;
layout(set = 2, binding = 1, scalar) writeonly buffer Segments { Segment segments[]; };
// Of each group of maps that are captured at once.
layout(set = 2, binding = 2, scalar) buffer Counters {
    uint cut_short;  // as BinTotals has it, of loops over a list
    uint fragments[];
};

void main() {
    View view = maps[map].volume;
    vec2 depth;
    float optical_depth;
    if (!texel_segment(view, splat_texel(view), casters[caster_index], depth, optical_depth)) {
        return;
    }
    uint index = atomicAdd(fragments[group], 1u);
    if (index < capacity) {
        uint next = imageAtomicExchange(heads, ivec2(gl_FragCoord.xy), index);
        segments[index] = Segment(depth.x, depth.y, optical_depth, caster_index, next);
    }
}
