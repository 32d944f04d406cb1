// Random numbers of a pixel in a frame, and random choices based on them. Everything is computed in integers or `precise`, so that the twin
// draws the same numbers. Source: O'Neill 2014, PCG (the permutation), as a hash: Jarzynski and Olano 2020, Hash functions for GPU
// rendering. Twin: reference::twin::reservoir.
#ifndef CONSUME_RESERVOIR_RANDOM_GLSL
#define CONSUME_RESERVOIR_RANDOM_GLSL

uint hashed(uint bits) {
    uint state = bits * 747796405u + 2891336453u;
    uint word = (state >> ((state >> 28) + 4u) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

uint pixel_seed(uint pixel, uint frame) { return hashed(hashed(pixel) + frame); }

// Random number `i` of the sequence with this seed.
uint random_bits(uint seed, uint i) { return hashed(seed + i); }

// Random number between 0 and 1.
float random_share(uint bits) {
    precise float share = (float(bits >> 8) + 0.5) / 16777216.0;
    return share;
}

// Candidate `i` of `candidates` among `lights`. The lights are split into equal parts, one per candidate, and each candidate is drawn from
// its own part. Over all candidates each light is drawn equally often.
uint candidate_light(uint bits, uint i, uint candidates, uint lights) {
    uint place, low;
    umulExtended(bits, lights, place, low);
    return (i * lights + place) / candidates;
}
#endif
