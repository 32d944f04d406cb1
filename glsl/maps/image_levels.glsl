// Levels of detail of maps whose texels are an image: coarser levels are in a buffer, as 32-bit floats. A technique defines LEVEL_WORDS,
// the number of words per texel there.
#ifndef MAPS_IMAGE_LEVELS_GLSL
#define MAPS_IMAGE_LEVELS_GLSL
#include "maps/level_tile.glsl"

// set 1: maps_image_levels
layout(set = 1, binding = 0) uniform texture2D texels;
layout(set = 1, binding = 1, scalar) coherent buffer LevelWords { uint level_words[]; };

// First word of a texel of a coarser level; `place`: the texel's index among those of all maps and levels.
uint coarser_word(uint place) {
    return LEVEL_WORDS * (place - level_first(map_size(), gl_NumWorkGroups.z, 1u));
}

// Position in the image of a texel of the map itself; `place`: see coarser_word.
ivec2 image_place(uint place) { return ivec2(place % map_size().x, place / map_size().x); }
#endif
