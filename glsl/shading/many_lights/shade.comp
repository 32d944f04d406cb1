#version 460
// Shades a tile's pixels with all of the tile's lights. With blur=on, a light's visibility at a pixel is a weighted mean over 5 × 5 pixels,
// without pixels that see a different surface. With history=on, the mean also includes these pixels' surfaces in the previous frame. A pair
// of pixels has the same weight for all lights, computed once. A word holds one bit per light, for 32 lights: a few operations on words add
// up the bits of all 32 lights at once. Sources: Pestana 2015; Valient 2014 (dither, then blur); adding up by words and the weights are
// ours. Twin: reference::twin::many_lights::shade. Inputs: lights, a tile's words, shadows, pixels' surfaces, sources, albedo, normal.
// Output: color. Invariant: the weights along a side are 1 2 2 2 1. So each of the four places of a dither of 4 × 4 pixels has the same
// total weight, and the dither leaves no pattern behind.
// variants: HALF 0 1
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
#include "shading/picture_set.glsl"
#include "shading/shading.glsl"
#include "shading/surface.glsl"
#include "shading/many_lights/geometry.glsl"
#include "shading/ambient.glsl"

// Half a tile: a workgroup size that every device supports.
layout(local_size_x = 16, local_size_y = 8) in;

// How many pixels the blur reaches on each side: 2, or 0 without blur.
CONSTANT(uint, BLUR_REACH, 2u)
CONSTANT(bool, HISTORY, false)

// set 1: many_lights_seen
#if HALF == 1
layout(set = 1, binding = 4, rgba16f) writeonly uniform image2D colors;
#else
layout(set = 1, binding = 4, rgba32f) writeonly uniform image2D colors;
#endif
SURFACE_ALBEDOS
SURFACE_NORMALS
SURFACE_DISTANCES

const uint MOST_AROUND = (16u + 4u) * (8u + 4u);

// The pixels of the half tile and the surrounding ones within reach of the blur.
shared float around_z[MOST_AROUND];
shared uint around_normals[MOST_AROUND];
shared uint around_sources[MOST_AROUND];
shared uint around_shadows[MOST_AROUND];
shared uint around_before[MOST_AROUND];

// Sums of weights for 32 lights, in binary: eight words, one per digit, the lowest digit first. Bit i of each word belongs to light i. A
// sum is at most 128: (1 + 2 + 2 + 2 + 1)² = 64 for each of two frames.
struct Sums {
    uvec4 low;
    uvec4 high;
};

// The exponent of a pixel's weight, which is a power of two.
uint weight_bits(ivec2 to) { return uint(abs(to.x) < 2) + uint(abs(to.y) < 2); }

// Adds three bits per light: `sum` gets the lower digit, `carry` the upper one.
void add_bits(uint a, uint b, uint c, out uint sum, out uint carry) {
    sum = a ^ b ^ c;
    carry = a & b | (a ^ b) & c;
}

// All ones if bit `bit` of `pixels` is set, else 0.
uint where_set(uint pixels, uint bit) { return uint(bitfieldExtract(int(pixels), int(bit), 1)); }

// For each of 32 lights, the weighted sum of the shadow bits of five adjacent pixels, in both frames. `first`: index of the first pixel in
// around_shadows and around_before. `counted`, `counted_before`: one bit per pixel, from bit `bit` on, set if the pixel counts in this
// frame and in the previous frame. The weights are 1 2 2 2 1, or twice these if `doubled`.
Sums sum_row(uint first, uint bit, uint counted, uint counted_before, bool doubled) {
    uint now[5], before[5];
    [[unroll]] for (uint x = 0u; x < 5u; ++x) {
        now[x] = where_set(counted, bit + x) & around_shadows[first + x];
        before[x] = HISTORY ? where_set(counted_before, bit + x) & around_before[first + x] : 0u;
    }
    uint ones, one, two, twos_a, twos_b, twos_c, twos_d, four, fours_a, fours_b, fours_c, fours_d, eight, eights_a, eights_b;
    uint two_sum, four_sum, sixteen;
    add_bits(now[0], now[4], before[0], ones, twos_a);
    add_bits(ones, before[4], 0u, one, twos_b);
    add_bits(now[1], now[2], now[3], twos_c, fours_a);
    add_bits(before[1], before[2], before[3], twos_d, fours_b);
    add_bits(twos_a, twos_b, twos_c, two_sum, fours_c);
    add_bits(two_sum, twos_d, 0u, two, fours_d);
    add_bits(fours_a, fours_b, fours_c, four_sum, eights_a);
    add_bits(four_sum, fours_d, 0u, four, eights_b);
    add_bits(eights_a, eights_b, 0u, eight, sixteen);
    return doubled ? Sums(uvec4(0u, one, two, four), uvec4(eight, sixteen, 0u, 0u))
                   : Sums(uvec4(one, two, four, eight), uvec4(sixteen, 0u, 0u, 0u));
}

Sums add_sums(Sums a, Sums b) {
    Sums sum;
    uint carry = 0u;
    add_bits(a.low.x, b.low.x, 0u, sum.low.x, carry);
    add_bits(a.low.y, b.low.y, carry, sum.low.y, carry);
    add_bits(a.low.z, b.low.z, carry, sum.low.z, carry);
    add_bits(a.low.w, b.low.w, carry, sum.low.w, carry);
    add_bits(a.high.x, b.high.x, carry, sum.high.x, carry);
    add_bits(a.high.y, b.high.y, carry, sum.high.y, carry);
    add_bits(a.high.z, b.high.z, carry, sum.high.z, carry);
    add_bits(a.high.w, b.high.w, carry, sum.high.w, carry);
    return sum;
}

uint sum_of(Sums sums, uint light) {
    uvec4 low = sums.low >> light & 1u, high = sums.high >> light & 1u;
    return (low.x | low.y << 1 | low.z << 2 | low.w << 3) | (high.x | high.y << 1 | high.z << 2 | high.w << 3) << 4;
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    uvec2 pixel = gl_GlobalInvocationID.xy;
    uvec2 corner = gl_WorkGroupID.xy * gl_WorkGroupSize.xy;
    int reach = int(BLUR_REACH);
    uint side = gl_WorkGroupSize.x + 2u * BLUR_REACH, count = side * (gl_WorkGroupSize.y + 2u * BLUR_REACH);
    for (uint i = thread; i < count; i += gl_WorkGroupSize.x * gl_WorkGroupSize.y) {
        ivec2 at = ivec2(corner + uvec2(i % side, i / side)) - reach;
        bool is_inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(size)));
        uint index = is_inside ? pixel_index(uvec2(at)) : 0u;
        uvec2 sees = is_inside ? geometry[index] : uvec2(0u);
        around_z[i] = uintBitsToFloat(sees.x);
        around_normals[i] = sees.y;
        around_sources[i] = HISTORY && is_inside ? sources[index] : NOWHERE;
    }
    barrier();

    // One bit for each surrounding pixel that counts, and the sum of their weights.
    uint middle = (gl_LocalInvocationID.y + BLUR_REACH) * side + gl_LocalInvocationID.x + BLUR_REACH;
    float z = around_z[middle];
    uint faces = around_normals[middle];
    uint counted = 0u, counted_before = 0u, weights = 0u;
    // Distance from the camera, along the normal, of the ray's point at z = 1, and its change per pixel.
    float away = along_normal(faces, frame_direction(frames[0], pixel));
    float across = along_normal(faces, frames[0].across);
    float down = along_normal(faces, frames[0].down);
    precise float plane = z * away, tolerance = float(NORMAL_UNIT) * frames[0].edge * z;
    uint bit = 0u;
    for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x, ++bit) {
            uint other = uint(int(middle) + y * int(side) + x);
            precise float off = around_z[other] * (away + float(x) * across + float(y) * down) - plane;
            bool same_surface =
                around_z[other] > 0.0 && abs(off) <= tolerance && same_normal(faces, around_normals[other]);
            bool counts = other == middle || same_surface;
            bool counts_before = counts && around_sources[other] != NOWHERE;
            counted |= uint(counts) << bit;
            counted_before |= uint(counts_before) << bit;
            weights += (uint(counts) + uint(counts_before)) << weight_bits(ivec2(x, y));
        }
    }
    float share = 1.0 / float(weights);
    vec3 normal = texelFetch(normals, ivec2(min(pixel, size - 1u)), 0).xyz;
    vec3 position = surface_position(surface_ray(frames[0].camera, vec2(pixel) + 0.5), z);
    vec3 light = ambient();

    uint first = tile_words(corner / TILE);
    for (uint word = 0u; word < words; ++word) {
        uint reaching = masks[first + word];
        if (reaching == 0u) {
            continue;
        }
        barrier();
        for (uint i = thread; i < count; i += gl_WorkGroupSize.x * gl_WorkGroupSize.y) {
            ivec2 at = ivec2(corner + uvec2(i % side, i / side)) - reach;
            around_shadows[i] = around_z[i] > 0.0 ? shadows[shadow_word(pixel_index(uvec2(at)), word)] : 0u;
            uint source = around_sources[i];
            around_before[i] = source != NOWHERE ? shadows_before[shadow_word(source, word)] : 0u;
        }
        barrier();
        Sums sums = Sums(uvec4(0u), uvec4(0u));
        if (BLUR_REACH == 0u) {
            // Without blur the pixel has weight 4 in this frame and in the previous frame.
            uint before = where_set(counted_before, 0u) & around_before[middle];
            add_bits(around_shadows[middle], before, 0u, sums.low.z, sums.low.w);
        } else {
            uint left = middle - BLUR_REACH * (side + 1u);
            [[unroll]] for (uint y = 0u; y < 5u; ++y) {
                bool doubled = y > 0u && y < 4u;
                sums = add_sums(sums, sum_row(left + y * side, 5u * y, counted, counted_before, doubled));
            }
        }
        for (uint left = reaching; left != 0u; left &= left - 1u) {
            uint at = uint(findLSB(left));
            Light of = lights[32u * word + at];
            float visibility = 1.0 - float(sum_of(sums, at)) * share;
            if (visibility > 0.0 && light_radiance(of, position) != vec3(0.0)) {
                light += light_on_surface(of, position, normal, vec3(visibility));
            }
        }
    }
    if (all(lessThan(pixel, size))) {
        vec3 albedo = texelFetch(albedos, ivec2(pixel), 0).rgb;
        vec3 color = z > 0.0 ? shade_surface(albedo, light) : vec3(sky_red, sky_green, sky_blue);
        imageStore(colors, ivec2(pixel), vec4(color, 1.0));
    }
}
