// Linear order of the texels of all reflective shadow maps: map by map, row by row. Twin: reference::twin::indirect::place.
#ifndef LIGHTS_INDIRECT_TEXELS_GLSL
#define LIGHTS_INDIRECT_TEXELS_GLSL

// Texels per side of a map, as a power of 2.
CONSTANT(uint, SIDE_BITS, 8u)

const uint SIDE = 1u << SIDE_BITS;

uint texel_map(uint texel) { return texel >> (2u * SIDE_BITS); }

uvec2 texel_place(uint texel) { return uvec2(texel, texel >> SIDE_BITS) & (SIDE - 1u); }
#endif
