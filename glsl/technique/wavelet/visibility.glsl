// Wavelet look-up: how much of light `light` reaches `position`, 0 to 1: means of the optical depth over even intervals of each texel's
// range stand in the intervals' middles, none at its beginning and all at its end, and between them it is linear. Source: Aizenshtein,
// Smal and McGuire 2022, Wavelet Transparency.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels, map after map, rows of texels: the range (maps/sums/range.glsl), then MEANS + 1 sums (maps/sums/halves.glsl)
// Specialization constants MEANS, SUM_RANGE and SUM_STORAGE as the texels were made.
// flat: bindings 120, constants 240: MEANS SUM_RANGE SUM_STORAGE FILTER FILTER_RADIUS
#include "technique/wavelet/parts.glsl"
#include "maps/sums/look_up.glsl"

float texel_transmittance(LookUp l, ivec2 texel) {
    uint at = texel_words_at(l, texel, words_of(SUMS));
    float place = texel_place(l, at);
    if (place <= 0.0 || place >= 1.0) {
        return place <= 0.0 ? 1.0 : exp(-visibility_sum(at, MEANS));
    }
    float middle = place * float(MEANS) - 0.5, below = floor(middle), along = middle - below;
    uint next = uint(below + 1.0);
    // Half an interval to either end.
    along = next == 0u ? 2.0 * along - 1.0 : next == MEANS ? 2.0 * along : along;
    float low = next == 0u ? 0.0 : visibility_sum(at, next - 1u);
    return exp(-mix(low, visibility_sum(at, next), along));
}
