#version 460
// The depth of a point: that of its middle. Source: Ritschel et al. 2008. Input: the map that it may not leave.
#include "technique/ism/map.glsl"

layout(location = 0) flat in uvec2 corner;

void main() {
    uvec2 texel = uvec2(gl_FragCoord.xy) - corner;
    if (any(greaterThanEqual(texel, uvec2(ISM_SIZE)))) {
        discard;
    }
}
