#version 460
// Opacity of a ball of uniform smoke, from the length of the ray inside it, and the light at its centre.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"
#include "shadow.glsl"

layout(location = 0) in vec2 corner;
layout(location = 1) in vec3 position;
layout(location = 2) flat in vec2 radius_and_extinction;
layout(location = 0) out vec4 color;

void main() {
    float half_way = radius_and_extinction.x * sqrt(max(1.0 - dot(corner, corner), 0.0));
    float hides = 1.0 - exp(-2.0 * half_way * radius_and_extinction.y);
    vec3 lit = SUN * sun_visibility(position) * 0.5 + SKY * 0.6;
    // Premultiplied by the opacity.
    color = vec4(0.9 * lit * hides, hides);
}
