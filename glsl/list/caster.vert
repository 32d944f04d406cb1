#version 460
// Draws casters as quads over a map, in the order of `order` from `order_first` on. Six vertices a caster.
// Inputs: map, casters, order. Outputs: position, caster index. Source: seed 000 (sample caster system).
#include "common/light.glsl"
#include "common/caster.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Order { uint order[]; };

layout(push_constant, scalar) uniform Push {
    uint map;
    uint order_first;
};

layout(location = 0) flat out uint caster_index;

void main() {
    caster_index = order[order_first + gl_VertexIndex / 6];
    gl_Position = caster_corner(maps[map].volume, casters[caster_index], gl_VertexIndex % 6);
}
