#version 460
// Draws the meshes as the camera sees them. Inputs: camera, triangles. Outputs: position, the triangle.
#include "shading/picture_set.glsl"
#include "shading/surface.glsl"
#include "world/light.glsl"
#include "world/triangle.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_TRIANGLES
PICTURE_SIDES

layout(location = 0) flat out vec3 corner;
layout(location = 1) flat out vec3 normal;
layout(location = 2) flat out vec3 albedo;
layout(location = 3) flat out vec2 z_range;
layout(location = 4) flat out uint is_closed;

void main() {
    Triangle triangle = triangles[gl_VertexIndex / 3];
    int side = sides[gl_VertexIndex / 3];
    Surface surface = surface_of(camera, triangle, side);
    corner = surface.corner;
    normal = surface.normal;
    z_range = surface.z;
    is_closed = uint(side != 0);
    albedo = triangle.albedo;
    gl_Position = surface_place(camera, triangle.corners[gl_VertexIndex % 3]);
}
