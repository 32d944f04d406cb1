// Wavelet look-up: how much of light `light` reaches `position`, 0 to 1, from means of the optical depth over even intervals of each
// texel's range. Each mean is taken as the optical depth at the middle of its interval. At the range's beginning the optical depth is 0, at
// the range's end it is that of all casters. Between these places it is interpolated linearly. Source: Aizenshtein, Smal and McGuire 2022,
// Wavelet Transparency.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels, map after map, rows of texels: the range (maps/sums/range.glsl), then MEANS + 1 sums (maps/sums/halves.glsl);
//              then the texels of coarser levels, as maps/level_place.glsl says
// Give the specialization constants MEANS, SUM_RANGE, SUM_STORAGE and LEVELS the values with which the texels were built.
// flat: bindings 120, constants 240: MEANS SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#include "maps/sums/look_up.glsl"
#include "technique/wavelet/read.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    return words_transmittance(texel_place(l, texel) * texel_words(), l.depth);
}
