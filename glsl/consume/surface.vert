#version 460
// Draws the meshes as the camera sees them. Inputs: camera, triangles. Outputs: position, the triangle.
#include "consume/picture_set.glsl"
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

float camera_z(vec3 position) { return dot(position - camera.origin, camera.forward); }

void main() {
    Triangle triangle = triangles[gl_VertexIndex / 3];
    corner = triangle.corners[0];
    vec3 z_all = vec3(camera_z(corner), camera_z(triangle.corners[1]), camera_z(triangle.corners[2]));
    z_range = vec2(min(min(z_all.x, z_all.y), z_all.z), max(max(z_all.x, z_all.y), z_all.z));
    // Outwards, where there is an outside.
    int side = sides[gl_VertexIndex / 3];
    normal = side < 0 ? -triangle_normal(triangle) : triangle_normal(triangle);
    is_closed = uint(side != 0);
    albedo = triangle.albedo;
    vec3 offset = triangle.corners[gl_VertexIndex % 3] - camera.origin;
    float z = z_all[gl_VertexIndex % 3];
    gl_Position = vec4(dot(offset, camera.right) * camera.scale_x, dot(offset, camera.up) * camera.scale_y,
                       (z - camera.near) * camera.far / (camera.far - camera.near), view_w(camera, z));
}
