#version 460
// What a caster leaves of the light, blended by multiplication into the light's buffer. Source: Kniss et al. 2003; Green 2008. Inputs: maps,
// casters. Output: transmittance. Twin: reference::twin::half_angle::light.
// Invariant: order matters only as far as blending rounds, and primitives blend in drawing order.
#define SPLAT_FRAGMENT
#include "maps/splat.glsl"

layout(location = 0) out float transmittance;

void main() {
    View view = maps[map].volume;
    vec2 depth;
    float optical_depth;
    if (!splat_segment(view, depth, optical_depth)) {
        discard;
    }
    transmittance = exp(-optical_depth);
}
