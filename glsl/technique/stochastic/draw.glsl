// Decides which samples of a texel end at a caster, and at which depth. Each sample is a ray of its own that ends at its first hit. Only
// that depth is kept, as bits, which compare like depths. Sources: Enderton et al. 2010 (samples; the nearest survivor); free flights
// instead of one alpha per caster are ours; SAMPLING_HASH: Filament (PR 3298), Jimenez 2014 (the noise); the hash: O'Neill 2014 (PCG),
// Jarzynski and Olano 2020. Twin: reference::twin::stochastic.
#ifndef TECHNIQUE_STOCHASTIC_DRAW_GLSL
#define TECHNIQUE_STOCHASTIC_DRAW_GLSL
#include "technique/stochastic/place.glsl"

// 0: each sample flies freely through each caster. 1: the texel's noise is compared with a caster's alpha, as engines do.
CONSTANT(uint, SAMPLING, 0u)

const uint SAMPLING_HASH = 1u;

// set 2: stochastic
layout(set = 2, binding = 0, scalar) buffer Samples { uint samples[]; };

uint stochastic_hash(uint bits) {
    uint state = bits * 747796405u + 2891336453u;
    uint word = (state >> ((state >> 28) + 4u) ^ state) * 277803737u;
    return word >> 22 ^ word;
}

// Returns a number strictly between 0 and 1.
float stochastic_share(uint bits) {
    precise float share = (float(bits >> 9) + 0.5) / 8388608.0;
    return share;
}

// texel_key: a texel's seed, the same in each map, so that a light's noise does not depend on other lights. caster_key: the seed of caster
// `number` in that texel.
uint texel_key(uvec2 texel) { return stochastic_hash(stochastic_hash(texel.y) ^ texel.x); }
uint caster_key(uint of_texel, uint number) { return stochastic_hash(of_texel ^ stochastic_hash(number)); }

// Interleaved gradient noise in integers: fract(52.9829189 · fract(0.06711056 x + 0.00583715 y)).
float gradient_noise(uvec2 texel) {
    uint bits = texel.x * 288237660u + texel.y * 25070368u, high, low;
    umulExtended(bits, 4221604530u, high, low);
    return stochastic_share(bits * 52u + high);
}

uint depth_bits(float depth) { return floatBitsToUint(abs(max(depth, 0.0))); }

// Called for each sample that ends at a depth; defined by each pass.
void keep_sample(uint place, uint bits);

// Lets each sample fly freely, independently of the other samples. The rays of a texel are laid end to end: a flight that leaves one ray
// continues in the next, which is valid since free flight has no memory. The work is therefore proportional to the number of samples that
// end. `first`: index of the texel's first sample.
void fly(uint key, uint first, vec2 depth, float optical_depth) {
    uint i = 0u;
    while (i < SAMPLES) {
        float flight = -log(stochastic_share(stochastic_hash(key + i)));
        if (!(flight < float(SAMPLES - i) * optical_depth)) {
            return;
        }
        float flown = flight / optical_depth;
        uint passed = min(uint(flown), SAMPLES - 1u - i);
        float share = min(flown - float(passed), 1.0);
        keep_sample(first + i + passed, depth_bits(mix(depth.x, depth.y, share)));
        i += passed + 1u;
    }
}

// Gives samples evenly spaced thresholds, shifted by the texel's noise. All casters are compared with the same thresholds, each at the
// depth of its midpoint.
void hash_alpha(float noise, uint first, vec2 depth, float optical_depth) {
    float taken = (1.0 - exp(-optical_depth)) * float(SAMPLES) - noise;
    for (uint i = 0u; i < SAMPLES && float(i) < taken; ++i) {
        keep_sample(first + i, depth_bits(0.5 * (depth.x + depth.y)));
    }
}

void draw_caster(uvec2 texel, uint number, uint first, vec2 depth, float optical_depth) {
    if (SAMPLING == SAMPLING_HASH) {
        hash_alpha(gradient_noise(texel), first, depth, optical_depth);
    } else {
        fly(caster_key(texel_key(texel), number), first, depth, optical_depth);
    }
}
#endif
