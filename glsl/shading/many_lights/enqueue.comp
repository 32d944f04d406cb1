#version 460
// shadows=queued, first of three passes: each block of 8 × 8 pixels appends its look-ups to a list, as jobs. A block goes from light to
// light, so that neighbouring jobs in the list have the same light and pixels close together, and nearly the same rays. If the list is
// full, the block does its look-ups itself: no result is lost. Blocks append in any order. The order makes no difference, since each job
// sets its own bit. Inputs: lights, a tile's words, albedo, normal, z, the technique. Outputs: jobs; shadows, with bits set only by blocks
// that found the list full.
#extension GL_EXT_samplerless_texture_functions : require
#include "visibility.glsl"
#include "shading/many_lights/answer.glsl"
#include "shading/many_lights/queue.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

shared uint wanted, begin, next;

void main() {
    uint thread = gl_LocalInvocationIndex;
    uvec2 pixel = gl_GlobalInvocationID.xy;
    bool is_asking = all(lessThan(pixel, size)) && !is_sky(min(pixel, size - 1u));
    Seen at = seen(min(pixel, size - 1u));
    uint first = tile_words(gl_WorkGroupID.xy * gl_WorkGroupSize.xy / TILE);
    for (uint word = 0u; word < words; ++word) {
        uint reaching = masks[first + word], asked = 0u;
        for (uint left = is_asking ? reaching : 0u; left != 0u; left &= left - 1u) {
            uint bit = uint(findLSB(left));
            asked |= uint(light_radiance(lights[32u * word + bit], at.position) != vec3(0.0)) << bit;
        }
        barrier();
        if (thread == 0u) {
            wanted = next = 0u;
        }
        barrier();
        atomicAdd(wanted, uint(bitCount(asked)));
        barrier();
        if (thread == 0u && wanted > 0u) {
            begin = atomicAdd(queue.demanded, wanted);
            if (begin > capacity || wanted > capacity - begin) {
                atomicMin(queue.end, begin);
                wanted = 0u;
            }
        }
        barrier();
        uint shadowed = 0u;
        for (uint left = reaching; left != 0u; left &= left - 1u) {
            uint bit = uint(findLSB(left)), light = 32u * word + bit;
            if ((asked >> bit & 1u) == 0u) {
                continue;
            }
            if (wanted > 0u) {
                jobs[begin + atomicAdd(next, 1u)] = pixel_index(pixel) << light_bits | light;
            } else {
                shadowed |= uint(is_shadowed(at, light)) << bit;
            }
        }
        if (is_asking) {
            shadows[shadow_word(pixel_index(pixel), word)] = shadowed;
        }
    }
}
