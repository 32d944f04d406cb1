#version 460
// Builds levels of detail of Beer shadow maps. Behind the farthest back of the four finer texels below it, a texel has their mean
// transmittance. Its front, or its back if the front alone cannot do so, is placed so that the area under its transmittance, from the
// nearest front to the farthest back, is the mean of their areas. A texel beyond the map's edge, or without casters, lets all light
// through. Source: ours. Inputs: maps, texels. Output: level_words. Twin: reference::twin::beer_shadow_map::merged.
#define LEVEL_WORDS 3u
#include "maps/image_levels.glsl"
#include "technique/beer_shadow_map/texel.glsl"

vec4 below_beer(LevelTile tile, uint place) {
    if (place == NONE) {
        return vec4(0.0);
    }
    if (tile.level == 1u) {
        vec4 texel = texelFetch(texels, image_place(place), 0);
        return vec4(texel.rgb, beer_most(texel));
    }
    uint at = coarser_word(place);
    return vec4(uintBitsToFloat(level_words[at]), uintBitsToFloat(level_words[at + 1u]), 0.0,
                uintBitsToFloat(level_words[at + 2u]));
}

// Returns the mean transmittance along a uniform medium of optical depth t: (1 − exp(−t)) / t, as a series where the subtraction would
// cancel.
float even_mean(float t) { return t < 0.01 ? 1.0 - t * (0.5 - t / 6.0) : (1.0 - exp(-t)) / t; }

void make_level(LevelTile tile) {
    uint t = gl_LocalInvocationIndex, place = t < tile_texels(tile) ? made_place(tile, t) : NONE;
    if (place == NONE) {
        return;
    }
    vec4 four[BELOW];
    vec2 ends = vec2(FARTHEST, -FARTHEST);
    for (uint i = 0u; i < BELOW; ++i) {
        four[i] = below_beer(tile, below_place(tile, below_texel(tile, t, i)));
        ends = four[i].a > 0.0 ? vec2(min(ends.x, 1.0 - four[i].r), max(ends.y, four[i].g)) : ends;
    }
    float tail = 0.0, area = 0.0;
    for (uint i = 0u; i < BELOW; ++i) {
        // Rounding may put a weighted front behind the back.
        float front = four[i].a > 0.0 ? 1.0 - four[i].r : ends.y, back = four[i].a > 0.0 ? max(four[i].g, front) : ends.y;
        float left = exp(-four[i].a);
        tail += 0.25 * left;
        area += 0.25 * ((front - ends.x) + (back - front) * even_mean(four[i].a) + (ends.y - back) * left);
    }
    vec4 merged = vec4(0.0);
    if (ends.x <= ends.y && tail < 1.0) {
        float taken = min(-log(max(tail, 1e-35)), 80.0), mean = even_mean(taken);
        vec2 depth = ends;
        // With hardly any optical depth, rounding would decide the result.
        if (mean <= 0.9999) {
            // The front solves (front − nearest) + (farthest − front) × mean = area, with the back at the farthest back. If that puts the
            // front before the nearest front, the front is the nearest front, and the back solves (back − nearest) × mean + (farthest −
            // back) × tail = area.
            depth.x = (area + ends.x - ends.y * mean) / (1.0 - mean);
            depth.y = depth.x < ends.x ? (area + ends.x * mean - ends.y * tail) / (mean - tail) : ends.y;
        }
        merged = beer_texel(clamp(depth, ends.xx, ends.yy), taken);
    }
    uint at = coarser_word(place);
    level_words[at] = floatBitsToUint(merged.r);
    level_words[at + 1u] = floatBitsToUint(merged.g);
    level_words[at + 2u] = floatBitsToUint(merged.a);
}
