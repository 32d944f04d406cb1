#version 460
// Draws casters as quads over a map, in the order of `order` from `order_first` on. Six vertices per caster.
// Inputs: maps, casters, order. Outputs: position, the caster in the view's axes, its index. Source: Fife and Strugar 2013, Sample particle
// system.
#include "maps/caster_quads.glsl"

// set 1: caster_quads
layout(set = 1, binding = 0, scalar) readonly buffer Order { uint order[]; };

layout(location = 0) flat out vec4 ball;
layout(location = 1) flat out vec4 rest;
layout(location = 2) flat out uint number;  // index of the caster

void main() {
    View view = maps[map].caster_view;
    number = order[order_first + gl_VertexIndex / 6];
    Caster caster = casters[map_casters(map) + number];
    gl_Position = caster_corner(view, caster, gl_VertexIndex % 6);
    // Transformed once per vertex instead of once per fragment.
    caster = view_caster(view, caster);
    ball = vec4(caster.position, caster.radius);
    rest = vec4(caster.axis, caster.density);
}
