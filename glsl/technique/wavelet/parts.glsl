// A segment's contribution to a texel's sums. The first MEANS sums belong to equal intervals of the range: each is the optical depth up to
// a place, averaged over all places of its interval. The last sum is the total optical depth. With 2^(R + 1) intervals, the sums carry the
// same information as Haar wavelets of rank R. Twin: reference::twin::wavelet.
#ifndef TECHNIQUE_WAVELET_PARTS_GLSL
#define TECHNIQUE_WAVELET_PARTS_GLSL

CONSTANT(uint, MEANS, 16u)  // number of intervals of a texel's range

const uint SUMS = MEANS + 1u;

// Shorter segments count as steps.
const float LEAST_LENGTH = 1e-20;

// Returns the share of a segment that lies before a place, averaged over the places from `low` to `high`.
float mean_share(vec2 place, float low, float high) {
    float from = clamp(place.x, low, high), to = clamp(place.y, low, high);
    // Behind the exit, the share is 1. Along the segment, it is the mean of the shares at `from` and `to`.
    float length_ = max(place.y - place.x, LEAST_LENGTH);
    float along = (to - from) * min(0.5 * ((from - place.x) + (to - place.x)) / length_, 1.0);
    return (along + (high - to)) / (high - low);
}

void segment_parts(vec2 place, float optical_depth, out float parts[SUMS]) {
    float side = 1.0 / float(MEANS);
    for (uint i = 0u; i < MEANS; ++i) {
        float low = float(i) * side;
        parts[i] = optical_depth * mean_share(place, low, low + side);
    }
    parts[MEANS] = optical_depth;
}
#endif
