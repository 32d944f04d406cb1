// Content of a texel: its range (maps/sums/range.glsl), then PLANES optical depths, each from the light to the end of a layer. The last
// layer ends with the range; points behind the range get its optical depth. Twin: reference::twin::layers.
#ifndef TECHNIQUE_LAYERS_LAYERS_GLSL
#define TECHNIQUE_LAYERS_LAYERS_GLSL
#include "maps/sums/range.glsl"

CONSTANT(uint, PLANES, 16u)      // optical depths per texel
CONSTANT(uint, SUM_STORAGE, 0u)  // storage of the optical depths. 0: 32 bits, 1: half floats, 2: 16 bits in units of DEEPEST / 65535

const uint STORAGE_F32 = 0u;
const uint STORAGE_F16 = 1u;
const uint STORAGE_FIXED = 2u;

// Optical depth beyond which no light is left, and the largest finite half float. Twins: DARK, and f16::MAX.
const float DEEPEST = 16.0;
const float GREATEST_HALF = 65504.0;

// Returns the words per texel.
uint texel_words() { return range_words() + (SUM_STORAGE == STORAGE_F32 ? PLANES : PLANES / 2u); }

// Returns where the k-th layer ends; k = 0 gives the start of the range. With RANGE_FRONT, each layer is thicker than the previous one by
// the thickness of the first.
float layer_end(uint k) {
    float of = float(PLANES);
    return SUM_RANGE == RANGE_FRONT ? float(k * (k + 1u)) / (of * (of + 1.0)) : float(k) / of;
}

// Returns the layer that contains a place, 0 for the first. An error of one layer does not matter, since ends are clamped.
uint layer_at(float place) {
    float of = float(PLANES);
    float layer = SUM_RANGE == RANGE_FRONT ? 0.5 * (sqrt(1.0 + 4.0 * place * of * (of + 1.0)) - 1.0) : place * of;
    return min(uint(layer), PLANES - 1u);
}
#endif
