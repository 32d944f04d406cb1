// Beer shadow map look-up: how much of light `light` reaches `position`, 0 to 1: light falls off evenly from a texel's front
// until its greatest optical depth is reached. Source: Hillaire 2020.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  texels as technique/beer_shadow_map/texel.glsl states them, R16G16B16A16_SFLOAT, the maps one above the other
// flat: bindings 8, constants 16: FILTER FILTER_RADIUS
#include "technique/beer_shadow_map/texel.glsl"
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_texels;

float texel_transmittance(LookUp l, ivec2 texel) {
    return exp(-beer_optical_depth(texelFetch(visibility_texels, stacked(l, texel), 0), l.depth));
}
