#version 460
// shadows=direct: each pixel queries the lights of its tile one by one. A light's bit is set where the light is shadowed.
// Source: Pestana 2015 (a bit per light). Inputs: lights, a tile's words, albedo, normal, z, the technique. Output: shadows.
#extension GL_EXT_samplerless_texture_functions : require
#include "visibility.glsl"
#include "shading/many_lights/answer.glsl"

// The threads of a subgroup shade neighbouring pixels.
layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, size)) || is_sky(pixel)) {
        return;
    }
    Seen at = seen(pixel);
    uint first = tile_words(gl_WorkGroupID.xy * gl_WorkGroupSize.xy / TILE);
    for (uint word = 0u; word < words; ++word) {
        uint shadowed = 0u;
        for (uint left = masks[first + word]; left != 0u; left &= left - 1u) {
            uint bit = uint(findLSB(left)), light = 32u * word + bit;
            if (light_radiance(lights[light], at.position) == vec3(0.0)) {
                continue;  // not queried: the light does not reach the point, or shines elsewhere
            }
            shadowed |= uint(is_shadowed(at, light)) << bit;
        }
        shadows[shadow_word(pixel_index(pixel), word)] = shadowed;
    }
}
