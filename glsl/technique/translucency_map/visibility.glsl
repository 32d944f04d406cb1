// Translucency map look-up: how much of light `light` reaches `position`, 0 to 1, as the transmittance of all casters on the ray, at any
// depth behind the near plane. Source: Crytek 2011; Bavoil and Jansen 2013, External Shadows.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  the products, R8_UNORM or R16_SFLOAT, the maps stacked vertically
//   binding 4  the products of coarser levels, as floats, laid out as in maps/level_place.glsl (any buffer if LEVELS is 1)
// Set the specialization constant LEVELS to the value that the texels were built with.
// flat: bindings 48, constants 96: FILTER FILTER_RADIUS NORMAL_BIAS LEVELS
#define MAP_TRANSMITTANCE leveled_transmittance
#include "maps/levels.glsl"

layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_products;
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityCoarser { float visibility_coarser[]; };

float texel_transmittance(LookUp l, ivec2 texel) {
    return l.first == 0u ? texelFetch(visibility_products, stacked(l, texel), 0).r
                         : visibility_coarser[coarser_place(l, texel)];
}
