// Reads a texel's means. Each mean is used as the optical depth at the midpoint of its interval. At the start of the range the optical
// depth is 0, at its end the total of all casters. In between it is interpolated linearly.
#ifndef TECHNIQUE_WAVELET_READ_GLSL
#define TECHNIQUE_WAVELET_READ_GLSL
#include "maps/sums/read_halves.glsl"
#include "technique/wavelet/parts.glsl"

uint texel_words() { return range_words() + words_of(SUMS); }

float kept_total(uint at) { return kept_sum(at, MEANS); }

float kept_transmittance(uint at, float place) {
    if (place <= 0.0 || place >= 1.0) {
        return place <= 0.0 ? 1.0 : exp(-kept_total(at));
    }
    float middle = place * float(MEANS) - 0.5, below = floor(middle), along = middle - below;
    uint next = uint(below + 1.0);
    // The ends of the range are only half an interval away from the first and the last midpoint.
    along = next == 0u ? 2.0 * along - 1.0 : next == MEANS ? 2.0 * along : along;
    float low = next == 0u ? 0.0 : kept_sum(at, next - 1u);
    return exp(-mix(low, kept_sum(at, next), along));
}
#endif
