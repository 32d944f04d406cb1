// The content of a texel: its range (maps/sums/range.glsl), then PLANES optical depths, each from the light to the end of a layer. The last
// layer ends with the range, and points behind the range get the optical depth of the last layer. Twin: reference::twin::layers.
#ifndef TECHNIQUE_LAYERS_LAYERS_GLSL
#define TECHNIQUE_LAYERS_LAYERS_GLSL
#include "maps/sums/range.glsl"

CONSTANT(uint, PLANES, 16u)      // optical depths of a texel
CONSTANT(uint, SUM_STORAGE, 0u)  // their storage: 0: 32 bits, 1: half floats, 2: 16 bits in units of DEEPEST / 65535

const uint STORAGE_F32 = 0u;
const uint STORAGE_F16 = 1u;
const uint STORAGE_FIXED = 2u;

// An optical depth behind which nothing is left, and the greatest half float. Twins: DARK, and f16::MAX.
const float DEEPEST = 16.0;
const float GREATEST_HALF = 65504.0;

// Words of a texel.
uint texel_words() { return range_words() + (SUM_STORAGE == STORAGE_F32 ? PLANES : PLANES / 2u); }

// Where layer k ends; k = 0 is no layer but the range's beginning. With RANGE_FRONT each layer is thicker than the one before,
// by as much as the first is thick.
float layer_end(uint k) {
    float of = float(PLANES);
    return SUM_RANGE == RANGE_FRONT ? float(k * (k + 1u)) / (of * (of + 1.0)) : float(k) / of;
}

// The layer in which a place is, 0 being the first. An error of one layer does not matter, since ends are clamped.
uint layer_at(float place) {
    float of = float(PLANES);
    float layer = SUM_RANGE == RANGE_FRONT ? 0.5 * (sqrt(1.0 + 4.0 * place * of * (of + 1.0)) - 1.0) : place * of;
    return min(uint(layer), PLANES - 1u);
}
#endif
