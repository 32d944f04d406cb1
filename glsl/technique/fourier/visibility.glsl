// Fourier look-up: how much of light `light` reaches `position`, 0 to 1. A series of sines and cosines over each texel's range gives the
// optical depth, clamped between 0 and the total. Source: Jansen and Bavoil 2010, Fourier Opacity Mapping.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  texels, map by map in rows: the range (maps/sums/range.glsl), then COEFFICIENTS sums (maps/sums/halves.glsl); then the
//              texels of coarser levels, as in maps/level_place.glsl
// Set the specialization constants COEFFICIENTS, SUM_RANGE, SUM_STORAGE and LEVELS to the values that the texels were built with.
// flat: bindings 104, constants 208: COEFFICIENTS SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#include "maps/sums/look_up.glsl"
#include "technique/fourier/read.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    return words_transmittance(texel_place(l, texel) * texel_words(), l.depth);
}
