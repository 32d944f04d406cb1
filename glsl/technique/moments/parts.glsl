// A segment's contribution to a texel's sums: its optical depth, then the optical depth times the exact mean of each function along the
// segment. Twin:
// reference::twin::moments.
#ifndef TECHNIQUE_MOMENTS_PARTS_GLSL
#define TECHNIQUE_MOMENTS_PARTS_GLSL
#include "maps/harmonics.glsl"
#include "maps/sums/halves.glsl"

CONSTANT(uint, MOMENTS, 4u)            // sums per texel besides its optical depth
CONSTANT(bool, TRIGONOMETRIC, false)  // moments of cosines and sines, half of each; else of Chebyshev polynomials, equivalent to powers

const uint SUMS = MOMENTS + 1u;

// Share of the circle that the range covers, so that the range's ends are apart.
const float ARC = 0.65;

// Returns the words per texel: the optical depth, then the other sums as floats, or their means, two per word.
uint moment_words() { return 1u + (SUM_STORAGE == STORAGE_F32 ? MOMENTS : MOMENTS / 2u); }

void segment_parts(vec2 place, float optical_depth, out float parts[SUMS]) {
    parts[0] = optical_depth;
    if (TRIGONOMETRIC) {
        Harmonic h = first_harmonic(ARC * place);
        for (uint k = 1u; k < SUMS; k += 2u) {
            vec2 mean = optical_depth * harmonic_mean(h);
            parts[k] = mean.x;
            parts[k + 1u] = mean.y;
            h = next_harmonic(h);
        }
        return;
    }
    float p = 2.0 * place.x - 1.0, q = 2.0 * place.y - 1.0;
    // Polynomials at p, and their divided differences from p to q.
    float before = 1.0, now = p, slope_before = 0.0, slope = 1.0;
    for (uint k = 1u; k < SUMS; ++k) {
        float slope_after = 2.0 * (q * slope + now) - slope_before, order = float(k);
        parts[k] = optical_depth * 0.5 * (slope_after / (order + 1.0) - (k > 1u ? slope_before / (order - 1.0) : 0.0));
        float after = 2.0 * p * now - before;
        before = now;
        now = after;
        slope_before = slope;
        slope = slope_after;
    }
}
#endif
