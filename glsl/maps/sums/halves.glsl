// How sums are stored: as they are, or two per word.
#ifndef MAPS_SUMS_HALVES_GLSL
#define MAPS_SUMS_HALVES_GLSL

CONSTANT(uint, SUM_STORAGE, 0u)  // storage of sums: 0: 32 bits, 1: half floats

const uint STORAGE_F32 = 0u;

const float GREATEST_HALF = 65504.0;

// Number of words for `count` sums.
uint words_of(uint count) { return SUM_STORAGE == STORAGE_F32 ? count : (count + 1u) / 2u; }

uint halves_of(float low, float high) { return packHalf2x16(clamp(vec2(low, high), -GREATEST_HALF, GREATEST_HALF)); }
#endif
