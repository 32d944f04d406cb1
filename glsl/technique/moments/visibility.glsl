// Moments look-up: how much of light `light` reaches `position`, 0 to 1. The moments of a texel's optical depth bound it from below and
// from above, as sharply as possible; the answer lies between the two bounds. In front of the texel's range it is all of the light, behind
// the range the transmittance of all casters. Source: Münstermann, Krumpen, Klein and Peters 2018, Moment-Based Order-Independent
// Transparency.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels, map after map, rows of texels: the range (maps/sums/range.glsl), the optical depth, then MOMENTS sums as they are,
//              or their means, SNORM, two to a word; then the texels of coarser levels, as maps/level_place.glsl says
// Give the specialization constants MOMENTS, TRIGONOMETRIC, SUM_RANGE, SUM_STORAGE and LEVELS the values with which the texels were built.
// flat: bindings 112, constants 224: MOMENTS TRIGONOMETRIC OVERESTIMATION SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#include "maps/sums/look_up.glsl"
#include "technique/moments/read.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    return words_transmittance(texel_place(l, texel) * texel_words(), l.depth);
}
