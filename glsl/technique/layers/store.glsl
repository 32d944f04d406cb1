// What a segment adds to a texel's layers, and how they are kept. Twin: reference::twin::layers.
#ifndef TECHNIQUE_LAYERS_STORE_GLSL
#define TECHNIQUE_LAYERS_STORE_GLSL
#include "maps/sums/set.glsl"
#include "technique/layers/layers.glsl"

#define SUMS PLANES

// Each layer's sum has all that lies before its end.
void segment_parts(vec2 place, float optical_depth, out float parts[SUMS]) {
    // A segment of no length is a step, and its own place lies behind it.
    float steepness = place.y > place.x ? 1.0 / (place.y - place.x) : 0.0;
    for (uint k = 0u; k < SUMS; ++k) {
        float end = layer_end(k + 1u);
        parts[k] = end >= place.y ? optical_depth : optical_depth * clamp((end - place.x) * steepness, 0.0, 1.0);
    }
}

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
