#version 460
// Finds where the casters on each texel's ray begin and end. Source: ours. Inputs: maps, casters. Output: ends. Twin:
// reference::twin::texel_sums.
// Invariant: ends are extremes, in whatever order the casters come. Depths are not negative, and compare as their bits do.
#define QUADS_FRAGMENT
#include "maps/caster_quads.glsl"

// set 2: maps_ends
// Two words per texel: the inverted bits of its front's depth, and the bits of its back's depth.
layout(set = 2, binding = 0, scalar) buffer Ends { uint ends[]; };

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (quad_part(view, DARK, depth, optical_depth) && optical_depth > 0.0) {
        uvec2 at = uvec2(gl_FragCoord.xy);
        uint texel = at.y * view.width + at.x;
        atomicMax(ends[2u * texel], ~floatBitsToUint(depth.x));
        atomicMax(ends[2u * texel + 1u], floatBitsToUint(depth.y));
    }
}
