#version 460
// Draws casters as the camera sees them, far to near. Six vertices per caster. Inputs: camera, casters, order.
#include "shading/picture_set.glsl"
#include "world/caster.glsl"

PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_ORDER

layout(location = 0) flat out uint caster_index;

void main() {
    caster_index = order[gl_VertexIndex / 6];
    gl_Position = caster_corner(camera, casters[caster_index], gl_VertexIndex % 6);
}
