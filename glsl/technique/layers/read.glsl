// Reads a texel's layers. The optical depth grows linearly from the end of one layer to the end of the next.
#ifndef TECHNIQUE_LAYERS_READ_GLSL
#define TECHNIQUE_LAYERS_READ_GLSL
#include "maps/sums/read.glsl"
#include "technique/layers/layers.glsl"

// Returns the optical depth from the light to the end of the k-th layer.
float layer_optical_depth(uint at, uint k) {
    if (k == 0u) {
        return 0.0;
    }
    if (SUM_STORAGE == STORAGE_F32) {
        return kept_float(at + k - 1u);
    }
    uint word = kept_word(at + (k - 1u) / 2u);
    vec2 two = SUM_STORAGE == STORAGE_F16 ? unpackHalf2x16(word) : unpackUnorm2x16(word) * DEEPEST;
    return (k & 1u) == 1u ? two.x : two.y;
}

float kept_total(uint at) { return layer_optical_depth(at, PLANES); }

float kept_transmittance(uint at, float place) {
    uint layer = layer_at(place);
    float begin = layer_end(layer), end = layer_end(layer + 1u);
    float along = clamp((place - begin) / (end - begin), 0.0, 1.0);
    return exp(-mix(layer_optical_depth(at, layer), layer_optical_depth(at, layer + 1u), along));
}
#endif
