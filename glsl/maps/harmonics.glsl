// Sines and cosines of a range's harmonics, and their means over segments. They are computed from products and sums, since devices round
// their own sines differently. Twin: reference::twin::harmonics.
#ifndef MAPS_HARMONICS_GLSL
#define MAPS_HARMONICS_GLSL

const float PI = 3.14159265;

// Segments shorter than this are treated as a step.
const float LEAST_LENGTH = 1e-20;

// cos and sin of `turns` full circles.
vec2 cis(float turns) {
    float quarters = floor(4.0 * turns + 0.5);
    float angle = 2.0 * PI * (turns - 0.25 * quarters);
    float square = angle * angle;
    float sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))));
    float cosine = 1.0 - square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)));
    int quarter = int(quarters) & 3;
    vec2 at = (quarter & 1) == 0 ? vec2(cosine, sine) : vec2(-sine, cosine);
    return quarter < 2 ? at : -at;
}

// Product of complex numbers.
vec2 turned(vec2 a, vec2 b) { return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x); }

// State of the iteration over a segment's harmonics, from the first one on.
struct Harmonic {
    vec2 once;   // cis of the segment's midpoint
    vec2 half_;  // cis of half its length
    vec2 at;     // at and chord: cis of the same two angles times the harmonic's order
    vec2 chord;
    float length_;
    float order;
};

Harmonic first_harmonic(vec2 place) {
    float length_ = place.y - place.x;
    vec2 once = cis(0.5 * (place.x + place.y)), half_ = cis(0.5 * length_);
    return Harmonic(once, half_, once, half_, length_, 1.0);
}

Harmonic next_harmonic(Harmonic h) {
    return Harmonic(h.once, h.half_, turned(h.at, h.once), turned(h.chord, h.half_), h.length_, h.order + 1.0);
}

// Mean of cis(order · place) over the segment: cis at its midpoint, times sin(π order length) / (π order length).
vec2 harmonic_mean(Harmonic h) {
    return h.at * (h.length_ > LEAST_LENGTH ? h.chord.y / (PI * h.order * h.length_) : 1.0);
}
#endif
