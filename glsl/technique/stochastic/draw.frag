#version 460
// Draws the depths at which a texel's samples end in a caster; the nearest end is kept. Source: Enderton et al. 2010. Inputs: maps,
// casters. Output: samples. Twin: reference::twin::stochastic::draw. Invariant: a minimum of integers, so the bytes are the same in any
// order.
#define QUADS_FRAGMENT
#include "maps/caster_quads.glsl"
#include "technique/stochastic/draw.glsl"

layout(location = 2) flat in uint number;

void keep_sample(uint place, uint bits) { atomicMin(samples[place], bits); }

void main() {
    View view = maps[map].caster_view;
    vec2 depth;
    float optical_depth;
    if (quad_segment(view, depth, optical_depth)) {
        uvec2 texel = quad_texel(view);
        draw_caster(texel, number, first_sample(view, map, texel), depth, optical_depth);
    }
}
