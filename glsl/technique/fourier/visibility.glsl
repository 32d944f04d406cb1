// Fourier look-up: how much of light `light` reaches `position`, 0 to 1: a series of sines and cosines over each texel's range says the
// optical depth, which is never taken for less than none or for more than all. Source: Jansen and Bavoil 2010, Fourier Opacity Mapping.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels, map after map, rows of texels: the range (maps/sums/range.glsl), then COEFFICIENTS sums (maps/sums/halves.glsl)
// Specialization constants COEFFICIENTS, SUM_RANGE and SUM_STORAGE as the texels were made.
// flat: bindings 104, constants 208: COEFFICIENTS SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS
#include "technique/fourier/parts.glsl"
#include "maps/sums/look_up.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    uint at = texel_words_at(l, texel, words_of(COEFFICIENTS));
    float place = texel_place(l, at), total = visibility_sum(at, 0u);
    if (place <= 0.0 || place >= 1.0) {
        return place <= 0.0 ? 1.0 : exp(-total);
    }
    vec2 once = cis(place), here = once;
    float optical_depth = total * place, order = 1.0;
    for (uint k = 1u; k < COEFFICIENTS; k += 2u) {
        float cosines = visibility_sum(at, k), sines = visibility_sum(at, k + 1u);
        optical_depth += (cosines * here.y + sines * (1.0 - here.x)) / (PI * order);
        here = turned(here, once);
        order += 1.0;
    }
    return exp(-clamp(optical_depth, 0.0, total));
}
