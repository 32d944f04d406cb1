// Writes a texel's words: its range, then its sums in the form of maps/sums/halves.glsl. Must be declared before inclusion: SUMS, their
// number.
#ifndef MAPS_SUMS_STORE_HALVES_GLSL
#define MAPS_SUMS_STORE_HALVES_GLSL
#include "maps/sums/halves.glsl"
#include "maps/sums/store.glsl"

void store_sums(uint texel, vec2 range, float sums[SUMS]) {
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
