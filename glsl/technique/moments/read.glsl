// Reads a texel's moments. The transmittance is interpolated between the tightest bounds that they imply.
#ifndef TECHNIQUE_MOMENTS_READ_GLSL
#define TECHNIQUE_MOMENTS_READ_GLSL
#include "maps/sums/read.glsl"
#include "technique/moments/share.glsl"

// Weight of the moments of a uniform distribution that are mixed in, so that the mixed moments belong to a valid distribution despite
// rounding.
const float BIAS = MOMENTS == 8u || SUM_STORAGE != STORAGE_F32 ? 3e-4 : 3e-5;

// A smaller optical depth is spread evenly, since its moments are mostly rounding error.
const float THIN = 2e-3;

uint texel_words() { return range_words() + moment_words(); }

float kept_total(uint at) { return kept_float(at); }

float kept_transmittance(uint at, float place) {
    float total = kept_total(at);
    if (place <= 0.0 || place >= 1.0) {
        return place <= 0.0 ? 1.0 : exp(-total);
    }
    if (total < THIN) {
        return exp(-total * place);
    }
    float means[MOST_MEANS];
    means[0] = 1.0;
    for (uint k = 1u; k < SUMS; k += 2u) {
        vec2 two = SUM_STORAGE == STORAGE_F32 ? vec2(kept_float(at + k), kept_float(at + k + 1u)) / total
                                              : unpackSnorm2x16(kept_word(at + (k + 1u) / 2u));
        means[k] = (1.0 - BIAS) * two.x;
        means[k + 1u] = (1.0 - BIAS) * two.y;
    }
    return exp(-total * moments_share(means, place));
}
#endif
