#version 460
// Draws the meshes as the camera sees them, for visible.frag. Inputs: camera, triangles. Outputs: position, the triangle's number.
#include "shading/camera_push.glsl"
#include "shading/picture_set.glsl"
#include "shading/surface.glsl"

PICTURE_TRIANGLES

layout(location = 0) flat out uint number;

void main() {
    number = uint(gl_VertexIndex) / 3u + 1u;
    gl_Position = surface_place(pushed_camera(), triangles[gl_VertexIndex / 3].corners[gl_VertexIndex % 3]);
}
