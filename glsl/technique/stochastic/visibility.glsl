// Stochastic shadow map look-up: how much of light `light` reaches `position`, 0 to 1, as the share of a texel's samples that have not
// ended before the point. Source: Enderton et al. 2010.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  depths at which samples end, as the bits of floats, 0xFFFFFFFF for a sample that never ends; map by map in rows of texels,
//              SAMPLES per texel
// flat: bindings 160, constants 320: FILTER FILTER_RADIUS NORMAL_BIAS SAMPLES
#include "technique/stochastic/place.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilitySamples { uint visibility_samples[]; };

float texel_transmittance(LookUp l, ivec2 texel) {
    uint first = first_sample(l.view, l.map, uvec2(texel)), before = floatBitsToUint(max(l.depth, 0.0)), left = 0u;
    for (uint i = 0u; i < SAMPLES; ++i) {
        left += visibility_samples[first + i] > before ? 1u : 0u;
    }
    return float(left) / float(SAMPLES);
}
