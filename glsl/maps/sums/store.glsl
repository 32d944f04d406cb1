// Writes a texel's words: its range, then its sums as maps/sums/halves.glsl keeps them. Needs, declared before: SUMS, how many.
#ifndef MAPS_SUMS_STORE_GLSL
#define MAPS_SUMS_STORE_GLSL
#include "maps/sums/halves.glsl"
#include "maps/sums/range.glsl"
#include "maps/sums/set.glsl"

// Where the texel's words go on behind its range.
uint store_range(uint texel, uint words, vec2 range) {
    uint at = texel * (range_words() + words);
    for (uint i = 0u; i < range_words(); ++i) {
        sum_words[at + i] = floatBitsToUint(range[i]);
    }
    return at + range_words();
}

void store_halves(uint texel, vec2 range, float sums[SUMS]) {
    uint at = store_range(texel, words_of(SUMS), range);
    if (SUM_STORAGE == STORAGE_F32) {
        for (uint k = 0u; k < SUMS; ++k) {
            sum_words[at + k] = floatBitsToUint(sums[k]);
        }
        return;
    }
    for (uint k = 0u; k < SUMS; k += 2u) {
        float high = 0.0;
        if (k + 1u < SUMS) {
            high = sums[k + 1u];
        }
        sum_words[at + k / 2u] = halves_of(sums[k], high);
    }
}
#endif
