#version 460
// Draws the meshes as the camera sees them, to find the points that virtual lights should light. Inputs: camera, triangles. Outputs:
// position, the triangle, the place in the world.
#include "shading/camera_push.glsl"
#include "shading/surface.glsl"
#include "maps/scene.glsl"

layout(location = 0) flat out uint triangle;
layout(location = 1) out vec3 place;

void main() {
    triangle = gl_VertexIndex / 3;
    place = triangles[triangle].corners[gl_VertexIndex % 3];
    gl_Position = surface_place(pushed_camera(), place);
}
