// A segment's contribution to a texel's sums: first its optical depth; then, for each harmonic of the range, the optical depth times the
// harmonic's mean cosine and mean sine along the segment, both exact. Twin: reference::twin::fourier.
#ifndef TECHNIQUE_FOURIER_PARTS_GLSL
#define TECHNIQUE_FOURIER_PARTS_GLSL
#include "maps/harmonics.glsl"

CONSTANT(uint, COEFFICIENTS, 7u)  // sums per texel: one, and two per harmonic

#define SUMS COEFFICIENTS

void segment_parts(vec2 place, float optical_depth, out float parts[SUMS]) {
    parts[0] = optical_depth;
    Harmonic h = first_harmonic(place);
    for (uint k = 1u; k < SUMS; k += 2u) {
        vec2 mean = optical_depth * harmonic_mean(h);
        parts[k] = mean.x;
        parts[k + 1u] = mean.y;
        h = next_harmonic(h);
    }
}
#endif
