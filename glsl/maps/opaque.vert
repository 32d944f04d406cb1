#version 460
// Draws the meshes as a light sees them. Inputs: maps, triangles. Outputs: position, z, normal, cut, the
// triangle.
#include "maps/scene.glsl"
#define ALPHA_TRIANGLES triangles
#include "maps/alpha_level.glsl"

layout(push_constant, scalar) uniform MapPush {
    uint map;
    uvec2 corner;  // the map's corner in the image, texels
};

layout(location = 0) out float z;
layout(location = 1) flat out vec3 normal;
// For a triangle cut by the near plane: x is the distance of the triangle's plane from the eye along the normal, y the z of its farthest
// corner. For other triangles y is 0.
layout(location = 2) flat out vec2 cut;

layout(location = 3) flat out uint number;
// Number of the triangle's alpha, 0 without; its level (see alpha_level), and its plane.
layout(location = 4) flat out uint record;
layout(location = 5) flat out uint level;
layout(location = 6) flat out vec3 plane[3];

void main() {
    View view = maps[map].opaque;
    number = uint(gl_VertexIndex) / 3u;
    Triangle triangle = triangles[number];
    normal = triangle_normal(triangle);
    vec3 all_z;
    for (int i = 0; i < 3; ++i) {
        all_z[i] = dot(triangle.corners[i] - view.origin, view.forward);
    }
    bool is_cut = view.projection == VIEW_PERSPECTIVE && min(min(all_z.x, all_z.y), all_z.z) < view.near;
    cut = vec2(dot(triangle.corners[0] - view.origin, normal), is_cut ? max(max(all_z.x, all_z.y), all_z.z) : 0.0);
    vec3 offset = triangle.corners[gl_VertexIndex % 3] - view.origin;
    z = all_z[gl_VertexIndex % 3];
    vec2 across = vec2(dot(offset, view.right) * view.scale_x, dot(offset, view.up) * view.scale_y);
    if (view.projection == VIEW_PARALLEL) {
        gl_Position = vec4(across, view_depth(view, z), 1.0);
    } else {
        gl_Position = vec4(across, (z - view.near) * view.far / (view.far - view.near), view_w(view, z));
    }
    record = alpha_number(number);
    plane = vec3[3](vec3(0.0), vec3(0.0), vec3(0.0));
    if (record != 0u) {
        AlphaPlane of_alpha = alpha_plane(triangle.corners);
        plane = vec3[3](of_alpha.first, of_alpha.second, of_alpha.third);
    }
    level = ALPHA_TEST == 0u || record == 0u ? 0u : alpha_level(view, triangle.corners, alpha_record(record));
    if (alpha_sees_through(number)) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // outside the clip volume
    }
}
