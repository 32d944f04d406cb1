#version 460
// shading=interleaved, first pass: each pixel of a square of 4 × 4 queries its own part of the lights. Sources: Keller and Heidrich 2001
// (interleaved sampling); Segovia et al. 2006 (pixels of one part side by side). Twin: reference::twin::interleaved::ask. Inputs: lights,
// camera, albedo, normal, z, the technique. Output: the light that each pixel reflects from its part of the lights. Invariant: all pixels
// of a workgroup have the same place in their squares, so that its threads query the same light at the same time.
#extension GL_EXT_samplerless_texture_functions : require
#include "shading/picture_set.glsl"
#include "shading/surface.glsl"
#include "shading/interleaved/parts.glsl"
#include "visibility.glsl"
#include "world/light.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

PICTURE_LIGHTS
PICTURE_CAMERA
SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES
// set 3: interleaved_written
layout(set = 3, binding = 0, scalar) writeonly buffer Estimates { vec3 estimates[]; };

#include "shading/surface_light.glsl"

void main() {
    uint place = gl_WorkGroupID.z;
    uvec2 pixel = 4u * gl_GlobalInvocationID.xy + place_pixel(place);
    if (any(greaterThanEqual(pixel, uvec2(camera.width, camera.height)))) {
        return;
    }
    vec3 light = vec3(0.0);
    // The sky needs no light.
    if (texelFetch(albedos, ivec2(pixel), 0).a != 0.0) {
        Ray ray = surface_ray(camera, vec2(pixel) + 0.5);
        float z = texelFetch(distances, ivec2(pixel), 0).r;
        vec3 position = surface_position(ray, z);
        light_footprint(pixel_side(camera, z));
        vec4 normal = texelFetch(normals, ivec2(pixel), 0);
        uint count = lights.length(), parts = part_count(count);
        for (uint i = place & parts - 1u; i < count; i += parts) {
            light += surface_light(i, position, normal.xyz, normal.w != 0.0);
        }
    }
    estimates[pixel.y * camera.width + pixel.x] = light;
}
