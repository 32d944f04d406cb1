#version 460
// Writes depth in the light's range, pushed away by what it changes over one texel in each direction and by its own
// rounding. Input: light. Output: depth.
// Invariant: a plane's stored depth lies behind the plane everywhere within one texel of the texel's centre.
#include "common/light.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Lights { Light lights[]; };

layout(location = 0) in float z;

void main() {
    float depth = view_depth(lights[0].opaque, z);
    // 4e-6 of the range: the rounding of a depth near 1 and of the look-up's projection.
    gl_FragDepth = depth + abs(dFdx(depth)) + abs(dFdy(depth)) + 4e-6;
}
