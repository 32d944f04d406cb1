#version 460
// Draws the sides of the triangles of lighting=vertex in black. A line is as dense as the centre of its caster, so that the lines of thin
// casters do not hide the smoke. Inputs: camera, casters, z of the meshes. Output: premultiplied color, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "query/colored.glsl"
#include "shading/distances_set.glsl"
#include "shading/picture_set.glsl"
#include "world/caster.glsl"

PICTURE_CAMERA
PICTURE_CASTERS
PICTURE_DISTANCES

layout(location = 0) flat in uint caster_index;
layout(location = 0) out vec4 color;

void main() {
    Caster caster = casters[channel_casters() + caster_index];
    float z = dot(caster.position + 0.5 * caster_axis(caster) - camera.origin, camera.forward);
    if (z > texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r) {
        discard;
    }
    float optical_depth = caster.density * (caster_is_step(caster) ? 1.0 : 2.0 * caster.radius);
    color = blended_color(vec3(0.0), 1.0 - exp(-optical_depth * extinction_ratio()));
}
