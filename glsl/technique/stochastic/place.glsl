// Layout of samples: map by map in rows of texels, with a texel's samples side by side.
#ifndef TECHNIQUE_STOCHASTIC_PLACE_GLSL
#define TECHNIQUE_STOCHASTIC_PLACE_GLSL
#include "world/view.glsl"

// Samples per texel.
CONSTANT(uint, SAMPLES, 16u)

// Depth of a sample that never ends: behind all others.
const uint NO_END = 0xFFFFFFFFu;

uint first_sample(View view, uint map, uvec2 texel) {
    return ((map * view.height + texel.y) * view.width + texel.x) * SAMPLES;
}
#endif
