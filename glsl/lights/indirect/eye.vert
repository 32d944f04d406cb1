#version 460
// Draws the meshes as the camera sees them, to find the points that virtual lights should light. Inputs: camera, triangles. Outputs:
// position, the triangle.
#include "shading/camera_push.glsl"
#include "shading/surface.glsl"
#include "maps/scene.glsl"

layout(location = 0) flat out uint triangle;

void main() {
    triangle = gl_VertexIndex / 3;
    gl_Position = surface_place(pushed_camera(), triangles[triangle].corners[gl_VertexIndex % 3]);
}
