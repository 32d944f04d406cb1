#version 460
// Shades a caster: single scattering, light visibility at the middle of what the camera ray sees of a sphere, or on a
// strand's lit side.
// Inputs: lights, camera, casters, z of the meshes, the technique. Output: premultiplied colour, blended over.
#extension GL_EXT_samplerless_texture_functions : require
#include "common/caster.glsl"
#include "common/shading.glsl"
#include "visibility.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 0, binding = 3, scalar) readonly buffer Casters { Caster casters[]; };
layout(set = 2, binding = 0) uniform texture2D distances;

layout(location = 0) flat in uint caster_index;
layout(location = 0) out vec4 color;

void main() {
    Caster caster = casters[caster_index];
    Ray ray = view_ray(camera, gl_FragCoord.xy);
    vec2 z;
    bool hit = caster_overlap(ray, caster, z);
    z.x = max(z.x, camera.near);
    z.y = min(z.y, texelFetch(distances, ivec2(gl_FragCoord.xy), 0).r);
    if (!hit || z.y < z.x) {
        discard;
    }
    float opacity = 1.0 - exp(-caster_optical_depth(ray, caster, z));
    vec3 position = ray.origin + 0.5 * (z.x + z.y) * ray.direction;
    vec3 light = vec3(0.0);
    for (uint i = 0u; i < lights.length(); ++i) {
        float visibility = light_visibility(i, lit_side(lights[i], caster, position));
        light += light_radiance(lights[i], position) * visibility;
    }
    color = vec4(shade_caster(caster, light) * opacity, opacity);
}
