// Wavelet look-up: how much of light `light` reaches `position`, 0 to 1, from means of the optical depth over equal intervals of each
// texel's range. Each mean is used as the optical depth at the midpoint of its interval. At the start of the range the optical depth is 0,
// at its end the total of all casters. In between it is interpolated linearly. Source: Aizenshtein, Smal and McGuire 2022, Wavelet
// Transparency.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  texels, map by map in rows: the range (maps/sums/range.glsl), then MEANS + 1 sums (maps/sums/halves.glsl); then the texels
//              of coarser levels, as in maps/level_place.glsl
// Set the specialization constants MEANS, SUM_RANGE, SUM_STORAGE and LEVELS to the values that the texels were built with.
// flat: bindings 120, constants 240: MEANS SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#include "maps/sums/look_up.glsl"
#include "technique/wavelet/read.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    return words_transmittance(texel_place(l, texel) * texel_words(), l.depth);
}
