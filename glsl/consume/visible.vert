#version 460
// Draws the meshes as the camera sees them, for visible.frag. Inputs: camera, triangles. Outputs: position, the triangle's number.
#include "consume/camera_push.glsl"
#include "consume/picture_set.glsl"
#include "consume/surface.glsl"

PICTURE_TRIANGLES

layout(location = 0) flat out uint number;

void main() {
    number = uint(gl_VertexIndex) / 3u + 1u;
    gl_Position = surface_place(pushed_camera(), triangles[gl_VertexIndex / 3].corners[gl_VertexIndex % 3]);
}
