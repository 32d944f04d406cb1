// Color from arriving light and albedo. Twin: reference::truth::picture.
#ifndef CONSUME_SHADING_GLSL
#define CONSUME_SHADING_GLSL
#include "world/caster.glsl"
#include "world/light.glsl"

const vec3 PARTICLE_ALBEDO = vec3(0.92, 0.92, 0.95);
const vec3 STRAND_ALBEDO = vec3(0.70, 0.42, 0.20);

// Light that a surface reflects from one light, by the visibility of each color. Lambert, two-sided.
vec3 light_on_surface(Light light, vec3 position, vec3 normal, vec3 visibility) {
    float cosine = abs(dot(normal, light_direction(light, position)));
    return light_radiance(light, position) * cosine * visibility;
}

// `light` is the sum over all lights and ambient light, here and below.
vec3 shade_surface(vec3 albedo, vec3 light) { return albedo * light; }

// Single scattering with an isotropic phase function, normalised so that a fully lit dense medium has its albedo.
vec3 shade_caster(vec3 albedo, vec3 light) { return albedo * light; }

// The color of casters without a color of their own.
vec3 caster_albedo(Caster caster) { return caster_is_strand(caster) ? STRAND_ALBEDO : PARTICLE_ALBEDO; }

// Where to ask for the light that arrives at `position` of a caster. A strand takes its light in one step of depth. Its own points lie on
// the edge of that step, so that they would be shadowed at random. So a strand asks one width in front of itself, towards the light. A
// splat is a piece of a surface. It asks in front of all of itself and of its neighbours, which it overlaps.
vec3 lit_side(Light light, Caster caster, vec3 position) {
    if (caster_is_splat(caster)) {
        vec3 towards = light_direction(light, position);
        SplatRay along = splat_ray(Ray(position, towards), caster.position, caster.radius, caster.axis);
        return position + max(SPLAT_REACH * along.deviation, caster.radius / SPLAT_REACH) * towards;
    }
    return caster_is_strand(caster) ? position + 2.0 * caster.radius * light_direction(light, position) : position;
}
#endif
