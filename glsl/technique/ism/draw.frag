#version 460
// Draws a point at the depth of its centre, within its own map. Source: Ritschel et al. 2008. Input: the map's corner.
#include "technique/ism/map.glsl"

layout(location = 0) flat in uvec2 corner;

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy) - corner;
    if (any(greaterThanEqual(texel, uvec2(ISM_SIZE)))) {
        discard;
    }
}
