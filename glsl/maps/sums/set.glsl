// Buffers that passes of sums write. Bound by maps::Sums.
#ifndef MAPS_SUMS_SET_GLSL
#define MAPS_SUMS_SET_GLSL
#extension GL_EXT_scalar_block_layout : require
// set 2: maps_sums
// A texel's words, as the technique packs them: map by map, rows of texels.
layout(set = 2, binding = 0, scalar) writeonly buffer SumWords { uint sum_words[]; };
#endif
