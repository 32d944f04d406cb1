#version 460
// Second half of deferred shading: reconstructs a pixel's position from z, and looks up the visibility of each light once per pixel.
// Inputs: lights, camera, albedo, normal, z, the technique. Output: color.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/picture_set.glsl"
#include "shading/shading.glsl"
#include "shading/surface.glsl"
#include "visibility.glsl"

PICTURE_LIGHTS
PICTURE_CAMERA
SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES

#include "shading/ambient.glsl"
#include "shading/surface_light.glsl"

layout(location = 0) out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 albedo = texelFetch(albedos, pixel, 0);
    if (albedo.a == 0.0) {
        discard;  // the sky stays
    }
    Ray ray = surface_ray(camera, gl_FragCoord.xy);
    float z = texelFetch(distances, pixel, 0).r;
    vec3 position = surface_position(ray, z);
    vec4 normal_and_closed = texelFetch(normals, pixel, 0);
    vec3 normal = normal_and_closed.xyz;
    bool closed = normal_and_closed.w != 0.0;
    light_footprint(pixel_side(camera, z));
    vec3 light = ambient();
    for (uint i = 0u; i < lights.length(); ++i) {
        light += surface_light(i, position, normal, closed);
    }
    color = vec4(shade_surface(albedo.rgb, light), 1.0);
}
