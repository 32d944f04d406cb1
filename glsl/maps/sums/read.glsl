// Reads a texel's words: its range, then its technique's words. The technique defines their number and their meaning.
#ifndef MAPS_SUMS_READ_GLSL
#define MAPS_SUMS_READ_GLSL
#include "maps/sums/range.glsl"

// Returns word i of the buffer that holds all texels' words.
uint kept_word(uint i);

// Number of words per texel, including its range.
uint texel_words();

// kept_total: the optical depth of all of a texel's casters. kept_transmittance: the transmittance up to a place of the texel's range, 0 to
// 1. `at`: the texel's first word after its range.
float kept_total(uint at);
float kept_transmittance(uint at, float place);

float kept_float(uint i) { return uintBitsToFloat(kept_word(i)); }

// Range of a texel; `first`: its first word.
vec2 kept_range(uint first) {
    vec2 range = vec2(0.0, 1.0);
    if (SUM_RANGE != RANGE_SCENE) {
        range.x = kept_float(first);
        range.y = SUM_RANGE == RANGE_FRONT ? 1.0 : kept_float(first + 1u);
    }
    return range;
}

// Transmittance up to a depth of a texel; `first`: its first word.
float words_transmittance(uint first, float depth) {
    return kept_transmittance(first + range_words(), range_place(kept_range(first), depth));
}
#endif
