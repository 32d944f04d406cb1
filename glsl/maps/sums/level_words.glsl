// The texels' words, for passes that build levels of detail. They include this file instead of maps/sums/set.glsl, since they also read the
// words.
#ifndef MAPS_SUMS_SET_GLSL
#define MAPS_SUMS_SET_GLSL
#extension GL_EXT_scalar_block_layout : require
// set 1: maps_level_sums
layout(set = 1, binding = 0, scalar) coherent buffer SumWords { uint sum_words[]; };
// Optical depths at the ends of cells (maps/sums/levels.glsl) of the last level of each pass, if another pass follows.
layout(set = 1, binding = 1, scalar) buffer LevelCurves { float level_curves[]; };

uint kept_word(uint i) { return sum_words[i]; }
#endif
