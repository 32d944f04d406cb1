#version 460
// lighting=vertex, last stage: shades a caster like caster.frag, but with the light from the vertices. Inputs: camera, casters, z of the
// meshes, light. Output: premultiplied color, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/shading.glsl"
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"
#include "world/triangle.glsl"

PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_TRIANGLES
PICTURE_SPLATS
PICTURE_DISTANCES

#include "shading/sheets.glsl"
#include "shading/caster_seen.glsl"

layout(location = 0) flat in uint caster_index;
layout(location = 1) in vec3 light;
layout(location = 0) out vec4 color;

void main() {
    Caster caster = casters[channel_casters() + caster_index];
    Ray ray = view_ray(camera, gl_FragCoord.xy);
    vec2 z;
    if (!caster_seen(camera, ray, caster, texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r, z)) {
        discard;
    }
    vec3 albedo = caster_color_of(caster, caster_index);
    color = caster_color(ray, caster, albedo, z, light);
}
