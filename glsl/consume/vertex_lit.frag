#version 460
// lighting=vertex, last stage: as caster.frag, save that light comes from the vertices.
// Inputs: camera, casters, z of the meshes, light. Output: premultiplied colour, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "consume/caster_seen.glsl"

layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 0, binding = 3, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 2, binding = 0) uniform texture2D distances;

layout(location = 0) flat in uint caster_index;
layout(location = 1) in vec3 light;
layout(location = 0) out vec4 color;

void main() {
    Caster caster = casters[caster_index];
    Ray ray = view_ray(camera, gl_FragCoord.xy);
    vec2 z;
    if (!caster_seen(camera, ray, caster, texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r, z)) {
        discard;
    }
    color = caster_color(ray, caster, z, light);
}
