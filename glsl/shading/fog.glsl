// Fog along a camera ray: single scattering in a homogeneous medium of albedo 1 with an isotropic phase function. The ray is marched in
// equal steps up to the mesh that it hits, or to the far plane. On its way to the ray, light is attenuated by the technique alone. Sources:
// Nishita, Miyamae and Nakamae 1987, section 3; Wyman 2011. Must be declared before inclusion: lights[], camera, light_visibility. Twin:
// reference::truth::fog.
#ifndef CONSUME_FOG_GLSL
#define CONSUME_FOG_GLSL
#include "query/colored.glsl"
#include "query/receiver.glsl"

layout(push_constant, scalar) uniform FogPush {
    float extinction;  // 1 / world unit
    uint steps;
};

// A light of radiance 1 gives a white surface radiance 1, so its irradiance is π. The phase function sends 1 / 4π of it into each
// direction.
const float PHASE = 0.25;

// Position in each step at which a pixel looks up light, 0 to 1. The offset is fixed per pixel and differs strongly between neighbours, so
// that steps do not show as bands. Source: Roberts 2018, The unreasonable effectiveness of quasirandom sequences: R2, in integers.
float place_in_step(uvec2 pixel) {
    return float((pixel.x * 3242174889u + pixel.y * 2447445414u) >> 8) / 16777216.0;
}

// Light that reaches a point from all lights.
vec3 light_in_fog(vec3 position) {
    vec3 light = vec3(0.0);
    for (uint i = 0u; i < lights.length(); ++i) {
        vec3 radiance = light_radiance(lights[i], position);
        if (any(greaterThan(radiance, vec3(0.0)))) {
            light += radiance * colored(light_visibility(i, position));
        }
    }
    return light;
}

// Scattered light, and 1 − transmittance, at a pixel whose ray ends at `end`.
vec4 fog_at(uvec2 pixel, float end) {
    Ray ray = view_ray(camera, vec2(pixel) + 0.5);
    float place = place_in_step(pixel);
    float step_depth = extinction * end * length(ray.direction) / float(steps);
    vec3 scattered = vec3(0.0);
    float transmittance = 1.0;
    for (uint i = 0u; i < steps; ++i) {
        float z = (float(i) + place) / float(steps) * end;
        vec3 position = ray.origin + z * ray.direction;
        light_footprint(pixel_side(camera, z));
        // Fraction of uniform light that the step scatters towards the camera: the integral of extinction · transmittance over the step.
        float behind = exp(-step_depth * float(i + 1u));
        scattered += (transmittance - behind) * light_in_fog(position);
        transmittance = behind;
    }
    return vec4(PHASE * scattered, 1.0 - transmittance);
}
#endif
