#version 460
// Draws the meshes as a light sees them. Inputs: maps, triangles. Outputs: position, z, normal.
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform MapPush {
    uint map;
    uvec2 corner;  // where it stands
};

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
