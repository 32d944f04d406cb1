// Reads a texel's series, whose value is the optical depth, clamped between 0 and the total.
#ifndef TECHNIQUE_FOURIER_READ_GLSL
#define TECHNIQUE_FOURIER_READ_GLSL
#include "maps/sums/read_halves.glsl"
#include "technique/fourier/parts.glsl"

uint texel_words() { return range_words() + words_of(COEFFICIENTS); }

float kept_total(uint at) { return kept_sum(at, 0u); }

float kept_transmittance(uint at, float place) {
    float total = kept_total(at);
    if (place <= 0.0 || place >= 1.0) {
        return place <= 0.0 ? 1.0 : exp(-total);
    }
    vec2 once = cis(place), here = once;
    float optical_depth = total * place, order = 1.0;
    for (uint k = 1u; k < COEFFICIENTS; k += 2u) {
        float cosines = kept_sum(at, k), sines = kept_sum(at, k + 1u);
        optical_depth += (cosines * here.y + sines * (1.0 - here.x)) / (PI * order);
        here = turned(here, once);
        order += 1.0;
    }
    return exp(-clamp(optical_depth, 0.0, total));
}
#endif
