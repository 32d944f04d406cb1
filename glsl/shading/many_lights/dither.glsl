// A pixel's random offsets. x: an offset along a step, or the threshold that turns a soft result into one bit. y and z: offsets
// across a voxel. Each is between 0 and 1, or negative without dither. Computed in integers. Twin:
// reference::twin::many_lights::dither.
#ifndef CONSUME_MANY_LIGHTS_DITHER_GLSL
#define CONSUME_MANY_LIGHTS_DITHER_GLSL
#include "shading/many_lights/frame.glsl"

// 0: no dither; 1: 4 × 4 pixels with an offset each (Bayer 1973), repeated over the picture; 2: low-discrepancy noise (Roberts 2018, The
// unreasonable effectiveness of quasirandom sequences: R2).
CONSTANT(uint, DITHER, 0u)

const uint DITHER_ORDERED = 1u;
const uint DITHER_NOISE = 2u;

// The highest 24 bits as a number from 0 to 1.
float share_of(uint bits) { return (float(bits >> 8) + 0.5) / 16777216.0; }

// The pixel's offsets. With history, frames alternate between two of them, selected by `phase`.
vec3 dither(uvec2 pixel) {
    if (DITHER == DITHER_ORDERED) {
        uint x = pixel.x & 3u, y = pixel.y & 3u;
        uint place = ((x ^ y) & 1u) << 3 | (y & 1u) << 2 | ((x ^ y) & 2u) | (y & 2u) >> 1;
        return vec3(uvec3(place, 4u * (place & 3u), 4u * (place >> 2)) * 4u + uvec3(1u, 4u, 4u) * phase) / 64.0;
    }
    if (DITHER == DITHER_NOISE) {
        uint half_way = phase == 3u ? 0x80000000u : 0u;
        uint along = pixel.x * 3242174889u + pixel.y * 2447445414u + half_way;
        uint across = pixel.x * 2447445414u - pixel.y * 3242174889u + half_way;
        return vec3(share_of(along), share_of(along), share_of(across));
    }
    return vec3(-1.0);
}
#endif
