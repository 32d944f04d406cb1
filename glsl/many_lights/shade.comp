#version 460
// Shades what a tile shows with all of its lights. With blur=on, how much of a light reaches a pixel is the mean over the 5 × 5
// pixels about it, of those that see the same surface, and with history=on of where they were in the frame before. Weights are
// found once a pair of pixels and not a light: words of 32 lights are added up bit by bit, all lights at once. Sources: Pestana
// 2015; Valient 2014 (dither, then blur); adding up bit by bit and the weights are ours. Twin: reference::twin::many_lights::shade.
// Inputs: lights, a tile's words, shadows, what pixels see, sources, albedo, normal. Output: colour.
// Invariant: weights along a side, 1 2 2 2 1, give each four pixels in a row the same in all, so that a dither of 4 × 4 pixels
// leaves no pattern behind.
// variants: HALF 0 1
#extension GL_EXT_samplerless_texture_functions : require
#extension GL_EXT_control_flow_attributes : require
#include "consume/shading.glsl"
#include "consume/surface.glsl"
#include "many_lights/geometry.glsl"

layout(local_size_x = 128) in;

// Pixels that the blur reaches on each side: 2, or 0 without.
CONSTANT(uint, BLUR_REACH, 2u)
CONSTANT(bool, HISTORY, false)

#if HALF == 1
layout(set = 1, binding = 4, rgba16f) writeonly uniform image2D colors;
#else
layout(set = 1, binding = 4, rgba32f) writeonly uniform image2D colors;
#endif
layout(set = 2, binding = 0) uniform texture2D albedos;
layout(set = 2, binding = 1) uniform texture2D normals;
layout(set = 2, binding = 2) uniform texture2D distances;

const uint MOST_SIDE = TILE + 4u;
// Pixels that a thread shades.
const uint MINE = 2u;
// Binary digits of a sum of weights: two frames of (1 + 2 + 2 + 2 + 1)².
const uint DIGITS = 8u;

// Of the tile and the pixels about it.
shared float around_z[MOST_SIDE * MOST_SIDE];
shared uint around_normals[MOST_SIDE * MOST_SIDE];
shared uint around_sources[MOST_SIDE * MOST_SIDE];
shared uint around_shadows[MOST_SIDE * MOST_SIDE];
shared uint around_before[MOST_SIDE * MOST_SIDE];

// A pixel's part in the sum, as a power of two.
uint weight_bits(ivec2 to) { return uint(abs(to.x) < 2) + uint(abs(to.y) < 2); }

// Three bits of each of 32 lights: their sums' lower and upper digits.
void add_bits(uint a, uint b, uint c, out uint sum, out uint carry) {
    sum = a ^ b ^ c;
    carry = a & b | (a ^ b) & c;
}

// A row of five pixels in two frames, `now` and `before`, their weights 1 2 2 2 1: the digits of its sum, 16 at most.
void sum_row(uint now[5], uint before[5], out uint row[5]) {
    uint ones, twos[4], two, fours[4], four, eights[2];
    add_bits(now[0], now[4], before[0], ones, twos[0]);
    add_bits(ones, before[4], 0u, row[0], twos[1]);
    add_bits(now[1], now[2], now[3], twos[2], fours[0]);
    add_bits(before[1], before[2], before[3], twos[3], fours[1]);
    add_bits(twos[0], twos[1], twos[2], two, fours[2]);
    add_bits(two, twos[3], 0u, row[1], fours[3]);
    add_bits(fours[0], fours[1], fours[2], four, eights[0]);
    add_bits(four, fours[3], 0u, row[2], eights[1]);
    add_bits(eights[0], eights[1], 0u, row[3], row[4]);
}

// Adds a row's sum, times 2^weight.
void add_row(inout uint digits[DIGITS], uint row[5], uint weight) {
    uint carry = 0u;
    [[unroll]] for (uint i = 0u; i < DIGITS; ++i) {
        uint digit = i >= weight && i < weight + 5u ? row[i - weight] : 0u;
        add_bits(digits[i], digit, carry, digits[i], carry);
    }
}

// All bits where the bit of a pixel is set, else none.
uint where(uint pixels, uint bit) { return uint(bitfieldExtract(int(pixels), int(bit), 1)); }

uint sum_of(uint digits[DIGITS], uint light) {
    uint sum = 0u;
    [[unroll]] for (uint i = 0u; i < DIGITS; ++i) {
        sum |= (digits[i] >> light & 1u) << i;
    }
    return sum;
}

void main() {
    uint thread = gl_LocalInvocationIndex;
    uvec2 tile = gl_WorkGroupID.xy;
    int reach = int(BLUR_REACH);
    uint side = TILE + 2u * BLUR_REACH;
    for (uint i = thread; i < side * side; i += gl_WorkGroupSize.x) {
        ivec2 at = ivec2(tile * TILE + uvec2(i % side, i / side)) - reach;
        bool is_inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, ivec2(size)));
        uint index = is_inside ? pixel_index(uvec2(at)) : 0u;
        uvec2 sees = is_inside ? geometry[index] : uvec2(0u);
        around_z[i] = uintBitsToFloat(sees.x);
        around_normals[i] = sees.y;
        around_sources[i] = HISTORY && is_inside ? sources[index] : NOWHERE;
    }
    barrier();

    // Which of the pixels about count, a bit each; and what those that do weigh in all.
    uint counted[MINE], counted_before[MINE];
    float share[MINE];
    bool is_seen[MINE];
    vec3 position[MINE], normal[MINE], light[MINE];
    [[unroll]] for (uint mine = 0u; mine < MINE; ++mine) {
        uvec2 within = uvec2(thread % TILE, thread / TILE + mine * (TILE / MINE));
        uvec2 pixel = tile * TILE + within;
        uint middle = (within.y + BLUR_REACH) * side + within.x + BLUR_REACH;
        float z = around_z[middle];
        is_seen[mine] = z > 0.0;
        counted[mine] = counted_before[mine] = 0u;
        light[mine] = vec3(0.0);
        uint sum = 0u;
        // How far from the camera, along the normal, a ray is at z = 1.
        float away = along_normal(around_normals[middle], frame_direction(frames[0], pixel));
        float across = along_normal(around_normals[middle], frames[0].across);
        float down = along_normal(around_normals[middle], frames[0].down);
        precise float plane = z * away, tolerance = float(NORMAL_UNIT) * frames[0].edge * z;
        uint bit = 0u;
        for (int y = -reach; y <= reach; ++y) {
            for (int x = -reach; x <= reach; ++x, ++bit) {
                uint other = uint(int(middle) + y * int(side) + x);
                precise float off = around_z[other] * (away + float(x) * across + float(y) * down) - plane;
                bool same_surface = around_z[other] > 0.0 && abs(off) <= tolerance
                                 && same_normal(around_normals[middle], around_normals[other]);
                bool counts = other == middle || same_surface;
                bool counts_before = counts && around_sources[other] != NOWHERE;
                counted[mine] |= uint(counts) << bit;
                counted_before[mine] |= uint(counts_before) << bit;
                sum += (uint(counts) + uint(counts_before)) << weight_bits(ivec2(x, y));
            }
        }
        share[mine] = 1.0 / float(max(sum, 1u));
        normal[mine] = texelFetch(normals, ivec2(min(pixel, size - 1u)), 0).xyz;
        position[mine] = surface_position(surface_ray(frames[0].camera, vec2(pixel) + 0.5), z);
    }

    uint first = tile_words(tile);
    for (uint word = 0u; word < words; ++word) {
        uint reaching = masks[first + word];
        if (reaching == 0u) {
            continue;
        }
        barrier();
        for (uint i = thread; i < side * side; i += gl_WorkGroupSize.x) {
            ivec2 at = ivec2(tile * TILE + uvec2(i % side, i / side)) - reach;
            around_shadows[i] = around_z[i] > 0.0 ? shadows[shadow_word(pixel_index(uvec2(at)), word)] : 0u;
            uint source = around_sources[i];
            around_before[i] = source != NOWHERE ? shadows_before[shadow_word(source, word)] : 0u;
        }
        barrier();
        uint digits[MINE][DIGITS];
        [[unroll]] for (uint mine = 0u; mine < MINE; ++mine) {
            uint middle = (thread / TILE + mine * (TILE / MINE) + BLUR_REACH) * side + thread % TILE + BLUR_REACH;
            [[unroll]] for (uint i = 0u; i < DIGITS; ++i) {
                digits[mine][i] = 0u;
            }
            if (BLUR_REACH == 0u) {
                // Of weight 4, both.
                uint before = where(counted_before[mine], 0u) & around_before[middle];
                add_bits(around_shadows[middle], before, 0u, digits[mine][2], digits[mine][3]);
                continue;
            }
            [[unroll]] for (uint y = 0u; y < 5u; ++y) {
                uint now[5], before[5], row[5];
                [[unroll]] for (uint x = 0u; x < 5u; ++x) {
                    uint other = middle + (y - 2u) * side + x - 2u, bit = 5u * y + x;
                    now[x] = where(counted[mine], bit) & around_shadows[other];
                    before[x] = HISTORY ? where(counted_before[mine], bit) & around_before[other] : 0u;
                }
                sum_row(now, before, row);
                add_row(digits[mine], row, uint(y > 0u && y < 4u));
            }
        }
        for (uint left = reaching; left != 0u; left &= left - 1u) {
            uint bit = uint(findLSB(left));
            Light of = lights[32u * word + bit];
            [[unroll]] for (uint mine = 0u; mine < MINE; ++mine) {
                float visibility = 1.0 - float(sum_of(digits[mine], bit)) * share[mine];
                if (visibility > 0.0 && light_radiance(of, position[mine]) != vec3(0.0)) {
                    light[mine] += light_on_surface(of, position[mine], normal[mine], visibility);
                }
            }
        }
    }

    [[unroll]] for (uint mine = 0u; mine < MINE; ++mine) {
        uvec2 pixel = tile * TILE + uvec2(thread % TILE, thread / TILE + mine * (TILE / MINE));
        if (all(lessThan(pixel, size))) {
            vec3 albedo = texelFetch(albedos, ivec2(pixel), 0).rgb;
            vec3 color = is_seen[mine] ? shade_surface(albedo, light[mine]) : vec3(sky_red, sky_green, sky_blue);
            imageStore(colors, ivec2(pixel), vec4(color, 1.0));
        }
    }
}
