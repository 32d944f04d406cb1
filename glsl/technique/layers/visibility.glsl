// Layers look-up: how much of light `light` reaches `position`, 0 to 1. The optical depth grows linearly from the end of one layer to the
// end of the next. Sources: Kim and Neumann 2001, Opacity Shadow Maps; Yuksel and Keyser 2008, Deep Opacity Maps.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  texels as in technique/layers/layers.glsl, map by map in rows; then the texels of coarser levels, as in
//              maps/level_place.glsl
// Set the specialization constants PLANES, SUM_RANGE, SUM_STORAGE and LEVELS to the values that the texels were built with.
// flat: bindings 96, constants 192: PLANES SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#include "maps/sums/look_up.glsl"
#include "technique/layers/read.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    return words_transmittance(texel_place(l, texel) * texel_words(), l.depth);
}
