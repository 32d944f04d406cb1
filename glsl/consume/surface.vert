#version 460
// Draws the meshes as the camera sees them. Inputs: camera, triangles.
#include "world/light.glsl"
#include "world/triangle.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 0, binding = 2, scalar) readonly buffer Triangles { Triangle triangles[]; };

layout(location = 0) out vec3 position;
layout(location = 1) flat out vec3 normal;
layout(location = 2) flat out vec3 albedo;

void main() {
    Triangle triangle = triangles[gl_VertexIndex / 3];
    position = triangle.corners[gl_VertexIndex % 3];
    normal = triangle_normal(triangle);
    albedo = triangle.albedo;
    vec3 offset = position - camera.origin;
    float z = dot(offset, camera.forward);
    gl_Position = vec4(dot(offset, camera.right) * camera.scale_x, dot(offset, camera.up) * camera.scale_y,
                       (z - camera.near) * camera.far / (camera.far - camera.near), z);
}
