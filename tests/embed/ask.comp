#version 460
// Computes the sun's visibility at each of a list of points, for a test to compare with Gobo's own program.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"
#include "shadow.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, scalar) readonly buffer Points { vec3 points[]; };
layout(set = 0, binding = 1, scalar) writeonly buffer Answers { float answers[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < points.length()) {
        answers[i] = sun_visibility(points[i]);
    }
}
