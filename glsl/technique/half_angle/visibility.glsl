// Half-angle slicing look-up: how much of light `light` reaches `position`, 0 to 1, while a picture is being painted. The result is the
// transmittance of the casters drawn into the light's buffer so far, at any depth behind the near plane. A surface gets the transmittance
// of all casters in front of the first mesh, since light reaches no surface behind that mesh. A point in smoke has a valid result only
// while its own slice is drawn. Source: Kniss et al. 2003, A Model for Volume Lighting and Modeling.
// Bindings 0 to 2: maps/look_up_set.glsl. The others:
//   binding 3  the light's buffer, R8_UNORM, R16_SFLOAT or R32_SFLOAT
// flat: bindings 248, constants 496: FILTER FILTER_RADIUS
#include "maps/look_up.glsl"

layout(set = GOBO_SET, binding = 3) uniform texture2D visibility_buffer;

float texel_transmittance(LookUp l, ivec2 texel) {
    return texelFetch(visibility_buffer, stacked(l, texel), 0).r;
}
