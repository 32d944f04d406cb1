#version 460
// lighting=vertex, third stage: computes the light that reaches a vertex of a caster's quad. Source: Fife and Strugar 2013, Tessellation
// and Bavoil and Jansen 2013, Particle Lighting with DX11. Twin: reference::twin::vertex_lit.
// Inputs: lights, camera, casters, z of the meshes, the technique. Output: light.
// Invariant: w is 1, so that light is linear over the screen between vertices, whatever the interpolation.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"
#include "shading/vertex_lit.glsl"
#include "world/light.glsl"
#include "visibility.glsl"

layout(quads, equal_spacing) in;

PICTURE_LIGHTS
PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_DISTANCES

#include "shading/caster_light.glsl"

layout(location = 0) patch in uint patch_caster;
layout(location = 1) patch in vec4 patch_corners;
layout(location = 0) flat out uint caster_index;
layout(location = 1) out vec3 light;

void main() {
    Caster caster = casters[patch_caster];
    vec2 pixel = vertex_pixel(camera, patch_corners, gl_TessCoord.xy);
    vec2 last = vec2(camera.width, camera.height) - 1.0;
    float farthest = texelFetch(distances, ivec2(clamp(pixel, vec2(0.0), last)), 0).r;
    vec3 asked = caster_asked(camera, view_ray(camera, pixel), caster, farthest);
    float side = vertex_side(camera, patch_corners, vec2(gl_TessLevelInner[0], gl_TessLevelInner[1]));
    light_footprint(side * pixel_side(camera, dot(asked - camera.origin, camera.forward)));
    light = caster_light(caster, asked);
    caster_index = patch_caster;
    gl_Position = vec4(mix(patch_corners.xy, patch_corners.zw, gl_TessCoord.xy), 0.5, 1.0);
}
