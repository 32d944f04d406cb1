// Writes a texel's range.
#ifndef MAPS_SUMS_STORE_GLSL
#define MAPS_SUMS_STORE_GLSL
#include "maps/sums/range.glsl"
#include "maps/sums/set.glsl"

// Writes a texel's range, and returns where its other words begin.
uint store_range(uint texel, uint words, vec2 range) {
    uint at = texel * (range_words() + words);
    for (uint i = 0u; i < range_words(); ++i) {
        sum_words[at + i] = floatBitsToUint(range[i]);
    }
    return at + range_words();
}
#endif
