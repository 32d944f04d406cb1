// Reads a texel's sums as stored by maps/sums/halves.glsl.
#ifndef MAPS_SUMS_READ_HALVES_GLSL
#define MAPS_SUMS_READ_HALVES_GLSL
#include "maps/sums/halves.glsl"
#include "maps/sums/read.glsl"

// Sum k; `at`: the word after the range.
float kept_sum(uint at, uint k) {
    if (SUM_STORAGE == STORAGE_F32) {
        return kept_float(at + k);
    }
    vec2 two = unpackHalf2x16(kept_word(at + k / 2u));
    return (k & 1u) == 0u ? two.x : two.y;
}
#endif
