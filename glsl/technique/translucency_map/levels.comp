#version 460
// Builds levels of detail of translucency maps: each texel is the mean of the four finer products below it. A texel beyond the map's edge
// lets all light through. Source: ours. Inputs: maps, products. Output: level_words. Twin: reference::twin::translucency_map::merged.
#define LEVEL_WORDS 1u
#include "maps/image_levels.glsl"

void make_level(LevelTile tile) {
    uint t = gl_LocalInvocationIndex, place = t < tile_texels(tile) ? made_place(tile, t) : NONE;
    if (place == NONE) {
        return;
    }
    float mean = 0.0;
    for (uint i = 0u; i < BELOW; ++i) {
        uint below = below_place(tile, below_texel(tile, t, i));
        mean += 0.25 * (below == NONE      ? 1.0
                        : tile.level == 1u ? texelFetch(texels, image_place(below), 0).r
                                           : uintBitsToFloat(level_words[coarser_word(below)]));
    }
    level_words[coarser_word(place)] = floatBitsToUint(mean);
}
