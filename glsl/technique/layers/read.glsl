// Reads a texel's layers. Needs, declared before: uint layer_word(uint i), word i of all.
#ifndef TECHNIQUE_LAYERS_READ_GLSL
#define TECHNIQUE_LAYERS_READ_GLSL
#include "technique/layers/layers.glsl"

// From the light to the end of layer k; `at`: of the texel's first.
float layer_optical_depth(uint at, uint k) {
    if (k == 0u) {
        return 0.0;
    }
    if (SUM_STORAGE == STORAGE_F32) {
        return uintBitsToFloat(layer_word(at + k - 1u));
    }
    uint word = layer_word(at + (k - 1u) / 2u);
    vec2 two = SUM_STORAGE == STORAGE_F16 ? unpackHalf2x16(word) : unpackUnorm2x16(word) * DEEPEST;
    return (k & 1u) == 1u ? two.x : two.y;
}

// Where the layers of the texel whose words begin at `at` lie.
vec2 layers_range(uint at) {
    vec2 range = vec2(0.0, 1.0);
    if (SUM_RANGE != RANGE_SCENE) {
        range.x = uintBitsToFloat(layer_word(at));
        range.y = SUM_RANGE == RANGE_FRONT ? 1.0 : uintBitsToFloat(layer_word(at + 1u));
    }
    return range;
}

// What is left of the light at a depth: its optical depth grows evenly from the end of one layer to that of the next.
float layers_transmittance(uint at, float depth) {
    vec2 range = layers_range(at);
    at += range_words();
    float place = range_place(range, depth);
    uint layer = layer_at(place);
    float begin = layer_end(layer), end = layer_end(layer + 1u);
    float along = clamp((place - begin) / (end - begin), 0.0, 1.0);
    return exp(-mix(layer_optical_depth(at, layer), layer_optical_depth(at, layer + 1u), along));
}
#endif
