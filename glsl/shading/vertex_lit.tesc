#version 460
// lighting=vertex, second stage: passes on a caster's quad and sets the number of parts into which it is divided. Source: Fife and Strugar
// 2013, Tessellation. Twin: reference::twin::vertex_lit. Inputs: camera, casters. Outputs: the quad, levels. Invariant: casters off the
// screen have level 0 and no triangles.
#include "shading/picture_set.glsl"
#include "shading/vertex_lit.glsl"

layout(vertices = 1) out;

PICTURE_CAMERA
PICTURE_CASTERS

layout(push_constant, scalar) uniform SpacingPush {
    float spacing;  // largest distance between neighbouring vertices, in pixels
};

layout(location = 0) in uint caster_index[];
layout(location = 0) patch out uint patch_caster;
layout(location = 1) patch out vec4 patch_corners;  // NDC, low then high

void main() {
    vec2 level;
    if (!lit_quad(camera, casters[caster_index[0]], spacing, patch_corners, level)) {
        level = vec2(0.0);
    }
    gl_TessLevelOuter[0] = gl_TessLevelOuter[2] = gl_TessLevelInner[1] = level.y;
    gl_TessLevelOuter[1] = gl_TessLevelOuter[3] = gl_TessLevelInner[0] = level.x;
    patch_caster = caster_index[0];
}
