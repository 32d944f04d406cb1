#version 460
// Draws casters as the camera sees them, in the order in which a technique paints them. Six vertices per caster.
// Inputs: camera, casters, sorted.
#include "shading/picture_set.glsl"
#include "world/caster.glsl"

PICTURE_CAMERA
PICTURE_CASTERS

// set 3: sliced_order
layout(set = 3, binding = 0, scalar) readonly buffer Sorted { uint sorted[]; };

layout(location = 0) flat out uint caster_index;

void main() {
    caster_index = sorted[gl_VertexIndex / 6];
    gl_Position = caster_corner(camera, casters[caster_index], gl_VertexIndex % 6);
}
