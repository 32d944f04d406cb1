// Translucency map look-up: how much of light `light` reaches `position`, 0 to 1: behind the near plane, whatever the
// depth, what all casters together leave. Source: Crytek 2011; Bavoil and Jansen 2013, External Shadows.
// Bindings 0 to 2: maps/look_up_set.glsl. Then
//   binding 3  the products, R8_UNORM or R16_SFLOAT, the maps one above the other
// flat: bindings 48, constants 96: FILTER FILTER_RADIUS
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_products;

float texel_transmittance(LookUp l, ivec2 texel) {
    return texelFetch(visibility_products, stacked(l, texel), 0).r;
}
