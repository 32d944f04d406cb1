// Moments look-up: how much of light `light` reaches `position`, 0 to 1: between the sharpest bounds that the moments of each texel's
// optical depth have; all of the light before its range, and what all casters leave behind it. Source: Münstermann, Krumpen, Klein and
// Peters 2018, Moment-Based Order-Independent Transparency.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels, map after map, rows of texels: the range (maps/sums/range.glsl), the optical depth, then MOMENTS sums as they are,
//              or their means, SNORM, two to a word
// Specialization constants MOMENTS, TRIGONOMETRIC, SUM_RANGE and SUM_STORAGE as the texels were made.
// flat: bindings 112, constants 224: MOMENTS TRIGONOMETRIC OVERESTIMATION SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS
#include "technique/moments/share.glsl"
#include "maps/sums/look_up.glsl"

// By how much the moments are drawn to those of an even distribution, so that rounding leaves them moments of something.
const float BIAS = MOMENTS == 8u || SUM_STORAGE != STORAGE_F32 ? 3e-4 : 3e-5;

// What takes less light is spread evenly: its moments are mostly rounding.
const float THIN = 2e-3;

float texel_transmittance(LookUp l, ivec2 texel) {
    uint at = texel_words_at(l, texel, moment_words());
    float place = texel_place(l, at), total = visibility_word(at);
    if (place <= 0.0 || place >= 1.0 ) {
        return place <= 0.0 ? 1.0 : exp(-total);
    }
    if (total < THIN) {
        return exp(-total * place);
    }
    float means[MOST_MEANS];
    means[0] = 1.0;
    for (uint k = 1u; k < SUMS; k += 2u) {
        vec2 two = SUM_STORAGE == STORAGE_F32 ? vec2(visibility_word(at + k), visibility_word(at + k + 1u)) / total
                                              : unpackSnorm2x16(visibility_words[at + (k + 1u) / 2u]);
        means[k] = (1.0 - BIAS) * two.x;
        means[k + 1u] = (1.0 - BIAS) * two.y;
    }
    return exp(-total * moments_share(means, place));
}
