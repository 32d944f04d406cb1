// Moments look-up: how much of light `light` reaches `position`, 0 to 1. The moments of a texel's optical depth give the tightest lower and
// upper bounds on it; the result lies between the two. In front of the texel's range the result is 1, behind the range the transmittance of
// all casters. Source: Münstermann, Krumpen, Klein and Peters 2018, Moment-Based Order-Independent Transparency.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  texels, map by map in rows: the range (maps/sums/range.glsl), the optical depth, then MOMENTS sums as floats, or their means
//              as SNORM, two per word; then the texels of coarser levels, as in maps/level_place.glsl
// Set the specialization constants MOMENTS, TRIGONOMETRIC, SUM_RANGE, SUM_STORAGE and LEVELS to the values that the texels were built with.
// flat: bindings 112, constants 224: MOMENTS TRIGONOMETRIC OVERESTIMATION SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#include "maps/sums/look_up.glsl"
#include "technique/moments/read.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    return words_transmittance(texel_place(l, texel) * texel_words(), l.depth);
}
