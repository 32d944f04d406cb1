// How light that arrives is turned into colour. Twin: reference::picture.
#ifndef COMMON_SHADING_GLSL
#define COMMON_SHADING_GLSL
#include "common/light.glsl"

const vec3 PARTICLE_ALBEDO = vec3(0.92, 0.92, 0.95);
const vec3 AMBIENT = vec3(0.10, 0.12, 0.15);

// Lambert, two-sided.
vec3 shade_surface(Light light, vec3 position, vec3 normal, vec3 albedo, float visibility) {
    float cosine = abs(dot(normal, light_direction(light, position)));
    return albedo * (AMBIENT + light_radiance(light, position) * cosine * visibility);
}

// Single scattering with an isotropic phase function, normalised so that a fully lit dense medium has its albedo.
vec3 shade_particle(Light light, vec3 position, float visibility) {
    return PARTICLE_ALBEDO * (AMBIENT + light_radiance(light, position) * visibility);
}
#endif
