// Stores a texel's moments. Twin: reference::twin::moments.
#ifndef TECHNIQUE_MOMENTS_STORE_GLSL
#define TECHNIQUE_MOMENTS_STORE_GLSL
#include "maps/sums/store.glsl"
#include "technique/moments/parts.glsl"

void store_sums(uint texel, vec2 range, float sums[SUMS]) {
    uint at = store_range(texel, moment_words(), range);
    sum_words[at] = floatBitsToUint(sums[0]);
    for (uint k = 1u; k < SUMS; k += 2u) {
        vec2 two = vec2(sums[k], sums[k + 1u]);
        if (SUM_STORAGE == STORAGE_F32) {
            sum_words[at + k] = floatBitsToUint(two.x);
            sum_words[at + k + 1u] = floatBitsToUint(two.y);
        } else {
            sum_words[at + (k + 1u) / 2u] = packSnorm2x16(sums[0] > 0.0 ? two / sums[0] : vec2(0.0));
        }
    }
}
#endif
