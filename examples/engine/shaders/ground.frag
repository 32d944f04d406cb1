#version 460
// Ground tiles, lit by the sunlight that gets through the smoke, and by the sky.
#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"
#include "shadow.glsl"

layout(location = 0) in vec3 position;
layout(location = 0) out vec4 color;

void main() {
    vec2 tile = floor(position.xy);
    float albedo = mod(tile.x + tile.y, 2.0) == 0.0 ? 0.32 : 0.28;
    vec3 lit = SUN * frame.to_light.z * sun_visibility(position, vec3(0, 0, 1)) + SKY * 0.8;
    float haze = 1.0 - exp(-0.004 * dot(position.xy, position.xy));
    color = vec4(mix(albedo * lit, SKY, haze), 1.0);
}
