#version 460
// Draws casters as the camera sees them, far to near. Six vertices a caster. Inputs: camera, casters, order.
#include "world/caster.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 0, binding = 3, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Order { uint order[]; };

layout(location = 0) flat out uint caster_index;

void main() {
    caster_index = order[gl_VertexIndex / 6];
    gl_Position = caster_corner(camera, casters[caster_index], gl_VertexIndex % 6);
}
