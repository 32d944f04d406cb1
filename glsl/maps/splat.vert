#version 460
// Draws casters as quads over a map, in the order of `order` from `order_first` on. Six vertices a caster.
// Inputs: maps, casters, order. Outputs: position, caster index. Source: Fife and Strugar 2013, Sample particle system.
#include "maps/scene.glsl"
#include "maps/splat.glsl"

layout(set = 1, binding = 0, scalar) readonly buffer Order { uint order[]; };

layout(location = 0) flat out uint caster_index;

void main() {
    caster_index = order[order_first + gl_VertexIndex / 6];
    gl_Position = caster_corner(maps[map].volume, casters[caster_index], gl_VertexIndex % 6);
}
