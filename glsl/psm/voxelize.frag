#version 460
// What a caster leaves of the light in its slices, blended by multiplication, or with ADDITIVE its optical depth, blended by
// addition; channels of other slices get 1, or 0. Source: Bavoil and Jansen 2013, Step 2. Inputs: maps, casters.
// Invariant: order matters only as far as blending rounds, and primitives blend in drawing order.
// Twin: reference::twin::psm::voxelize.
#include "maps/scene.glsl"
#include "maps/segment.glsl"
#include "psm/constants.glsl"
#include "psm/push.glsl"

layout(location = 0) flat in uint caster_index;
layout(location = 1) flat in vec4 shares;
layout(location = 2) flat in uint instance;
layout(location = 0) out vec4 color;

void main() {
    if (shares.x < 0.0) {
        color = vec4(ADDITIVE ? 1.0 : 0.0);
        return;
    }
    uint map = drawn_map(instance);
    vec2 depth;
    float optical_depth;
    if (!texel_segment(maps[map].volume, uvec2(gl_FragCoord.xy), casters[caster_index], depth, optical_depth)) {
        discard;
    }
    vec4 depths = optical_depth * shares;
    color = ADDITIVE ? depths : exp(-depths);
}
