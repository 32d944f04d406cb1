#version 460
// Draws the meshes as a light sees them, for a reflective shadow map. Inputs: maps, triangles. Outputs: position, the triangle, the place
// in the world.
#include "maps/scene.glsl"

layout(push_constant, scalar) uniform SeenPush {
    uint map;
    uvec2 corner;  // the map's corner in the image, texels
};

layout(location = 0) flat out uint triangle;
layout(location = 1) out vec3 place;

void main() {
    View view = maps[map].opaque;
    triangle = gl_VertexIndex / 3;
    place = triangles[triangle].corners[gl_VertexIndex % 3];
    vec3 offset = place - view.origin;
    float z = dot(offset, view.forward);
    vec2 across = vec2(dot(offset, view.right) * view.scale_x, dot(offset, view.up) * view.scale_y);
    if (view.projection == VIEW_PARALLEL) {
        gl_Position = vec4(across, view_depth(view, z), 1.0);
    } else {
        gl_Position = vec4(across, (z - view.near) * view.far / (view.far - view.near), view_w(view, z));
    }
}
