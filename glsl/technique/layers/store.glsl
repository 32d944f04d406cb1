// Stores a texel's layers. Twin: reference::twin::layers.
#ifndef TECHNIQUE_LAYERS_STORE_GLSL
#define TECHNIQUE_LAYERS_STORE_GLSL
#include "maps/sums/set.glsl"
#include "technique/layers/parts.glsl"

void store_sums(uint texel, vec2 range, float sums[SUMS]) {
    uint at = texel * texel_words();
    for (uint i = 0u; i < range_words(); ++i) {
        sum_words[at + i] = floatBitsToUint(range[i]);
    }
    at += range_words();
    if (SUM_STORAGE == STORAGE_F32) {
        for (uint k = 0u; k < SUMS; ++k) {
            sum_words[at + k] = floatBitsToUint(sums[k]);
        }
        return;
    }
    for (uint k = 0u; k < SUMS; k += 2u) {
        vec2 two = vec2(sums[k], sums[k + 1u]);
        sum_words[at + k / 2u] = SUM_STORAGE == STORAGE_F16 ? packHalf2x16(min(two, GREATEST_HALF))
                                                            : packUnorm2x16(two / DEEPEST);
    }
}
#endif
