#version 460
// Multiplies a caster's transmittance into a texel. Source: Crytek 2011; Bavoil and Jansen 2013, External Shadows. Inputs: maps, casters.
// Output: transmittance. Twin: reference::twin::translucency_map::multiply. Invariant: order affects only the rounding of the blending, and
// primitives blend in drawing order.
#define QUADS_FRAGMENT
#include "maps/caster_quads.glsl"

layout(location = 0) out float transmittance;

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (!quad_segment(view, depth, optical_depth)) {
        discard;
    }
    transmittance = exp(-optical_depth);
}
