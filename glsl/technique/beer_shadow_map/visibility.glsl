// Beer shadow map look-up: how much of light `light` reaches `position`, 0 to 1. From a texel's front on, the optical depth grows linearly
// with depth until it reaches the texel's maximum. Source: Hillaire 2020.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  texels as in technique/beer_shadow_map/texel.glsl, R16G16B16A16_SFLOAT, the maps stacked vertically
//   binding 4  texels of coarser levels, red, green and alpha as floats, as in maps/level_place.glsl (any buffer if LEVELS is 1)
// Set the specialization constant LEVELS to the value that the texels were built with.
// flat: bindings 8, constants 16: FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#define MAP_TRANSMITTANCE leveled_transmittance
#include "technique/beer_shadow_map/texel.glsl"
#include "maps/levels.glsl"

layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_texels;
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityCoarser { vec3 visibility_coarser[]; };

vec4 beer_at(LookUp l, ivec2 texel) {
    if (l.first == 0u) {
        return texelFetch(visibility_texels, stacked(l, texel), 0);
    }
    vec3 coarser = visibility_coarser[coarser_place(l, texel)];
    return vec4(coarser.xy, 0.0, coarser.z);
}

float texel_transmittance(LookUp l, ivec2 texel) {
    return exp(-beer_optical_depth(beer_at(l, texel), l.depth));
}
