#version 460
// Multiplies a caster's transmittance into its slices, or with ADDITIVE adds its optical depth; channels of other slices get 1, or 0 with
// ADDITIVE. Source: Bavoil and Jansen 2013, Step 2. Input: maps. Invariant: order affects only the rounding of the blending, and primitives
// blend in drawing order. Twin: reference::twin::psm::voxelize.
#include "maps/bins/view_caster.glsl"
#include "maps/scene.glsl"
#define ALPHA_TRIANGLES triangles
#include "world/sheet.glsl"
#include "technique/psm/constants.glsl"
#include "technique/psm/push.glsl"

// The caster in the view's axes: its position and radius, its axis and density.
layout(location = 0) flat in vec4 ball;
layout(location = 1) flat in vec4 rest;
layout(location = 2) flat in vec4 shares;
layout(location = 3) flat in uint instance;
layout(location = 0) out vec4 color;

void main() {
    if (shares.x < 0.0) {
        color = vec4(ADDITIVE ? 1.0 : 0.0);
        return;
    }
    View view = maps[drawn_map(instance)].caster_view;
    Caster caster = Caster(ball.xyz, ball.w, STRANDS || SPLATS_OR_CELLS || SHEETS ? rest.xyz : vec3(0.0), rest.w);
    Ray ray = view_texel_ray(view, uvec2(gl_FragCoord.xy));
    vec2 z;
    float optical_depth;
    if (!view_segment(view, ray, length(ray.direction), caster, MAX_OPTICAL_DEPTH, z, optical_depth)) {
        discard;
    }
    vec4 depths = optical_depth * shares;
    color = ADDITIVE ? depths : exp(-depths);
}
