#version 460
// Blends a caster into a texel: the nearest entry, the farthest exit, the sum of optical depths. Color is blended by maximum, alpha by
// addition. Source: Hillaire 2020. Inputs: maps, casters. Output: texel (technique/beer_shadow_map/texel.glsl). Twin:
// reference::twin::beer_shadow_map::blend. Invariant: order affects only the rounding of the sum, and primitives blend in drawing order.
#define QUADS_FRAGMENT
#include "technique/beer_shadow_map/texel.glsl"
#include "maps/caster_quads.glsl"

layout(location = 0) out vec4 texel;

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (!quad_segment(view, depth, optical_depth) || optical_depth <= 0.0) {
        discard;
    }
    texel = beer_texel(depth, optical_depth);
}
