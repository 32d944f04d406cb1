#version 460
// Second half of deferred shading: the position comes back from z, the visibility of each light is looked up once a pixel.
// Inputs: lights, camera, albedo, normal, z, the technique. Output: colour.
#extension GL_EXT_samplerless_texture_functions : require
#include "consume/shading.glsl"
#include "consume/surface.glsl"
#include "visibility.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Cameras { View camera; };
layout(set = 2, binding = 0) uniform texture2D albedos;
layout(set = 2, binding = 1) uniform texture2D normals;
layout(set = 2, binding = 2) uniform texture2D distances;

#include "consume/ambient.glsl"
#include "consume/surface_light.glsl"

layout(location = 0) out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 albedo = texelFetch(albedos, pixel, 0);
    if (albedo.a == 0.0) {
        discard;  // the sky stays
    }
    Ray ray = surface_ray(camera, gl_FragCoord.xy);
    vec3 position = surface_position(ray, texelFetch(distances, pixel, 0).r);
    vec4 normal_and_closed = texelFetch(normals, pixel, 0);
    vec3 normal = normal_and_closed.xyz;
    bool closed = normal_and_closed.w != 0.0;
    vec3 light = ambient();
    for (uint i = 0u; i < lights.length(); ++i) {
        light += surface_light(i, position, normal, closed);
    }
    color = vec4(shade_surface(albedo.rgb, light), 1.0);
}
