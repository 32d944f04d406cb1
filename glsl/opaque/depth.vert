#version 460
// Draws the meshes as the light sees them. Inputs: map, triangles.
#include "common/light.glsl"
#include "common/triangle.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Triangles { Triangle triangles[]; };

layout(push_constant, scalar) uniform Push { uint map; };

layout(location = 0) out float z;
layout(location = 1) flat out vec3 normal;

void main() {
    View view = maps[map].opaque;
    normal = triangle_normal(triangles[gl_VertexIndex / 3]);
    vec3 offset = triangles[gl_VertexIndex / 3].corners[gl_VertexIndex % 3] - view.origin;
    z = dot(offset, view.forward);
    vec2 across = vec2(dot(offset, view.right) * view.scale_x, dot(offset, view.up) * view.scale_y);
    if (view.projection == VIEW_PARALLEL) {
        gl_Position = vec4(across, view_depth(view, z), 1.0);
    } else {
        gl_Position = vec4(across, (z - view.near) * view.far / (view.far - view.near), z);
    }
}
