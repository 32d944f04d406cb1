#version 460
// Shades simulated particles: colored by speed or white, lit at their centres. Inputs: lights, the technique. Output: color.
#include "shading/picture_set.glsl"
#include "shading/shading.glsl"
#include "visibility.glsl"
#include "query/colored.glsl"

PICTURE_LIGHTS

#include "shading/ambient.glsl"

layout(push_constant, scalar) uniform PointsPush {
    float fastest;  // the speed that gets the ramp's last color; 0: all particles are white
};

layout(location = 0) flat in vec3 middle;
layout(location = 1) flat in float speed;
layout(location = 2) flat in float z;
layout(location = 0) out vec4 color;

// From slow to fast. Twin: shading::points::RAMP.
const vec3 RAMP[4] = vec3[4](vec3(0.02, 0.10, 0.45), vec3(0.03, 0.55, 0.65), vec3(0.95, 0.80, 0.25), vec3(1.0, 0.22, 0.06));

vec3 ramp(float share) {
    float at = 3.0 * clamp(share, 0.0, 1.0);
    uint first = min(uint(at), 2u);
    return mix(RAMP[first], RAMP[first + 1u], at - float(first));
}

void main() {
    vec3 light = ambient();
    for (uint i = 0u; i < lights.length(); ++i) {
        light += light_radiance(lights[i], middle) * colored(light_visibility(i, middle));
    }
    vec3 albedo = fastest > 0.0 ? ramp(speed / fastest) : PARTICLE_ALBEDO;
    color = vec4(shade_surface(albedo, light), 1.0);
}
