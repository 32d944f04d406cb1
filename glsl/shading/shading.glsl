// Color from incident light and albedo. Twin: reference::truth::picture.
#ifndef CONSUME_SHADING_GLSL
#define CONSUME_SHADING_GLSL
#include "world/caster.glsl"
#include "world/light.glsl"

const vec3 PARTICLE_ALBEDO = vec3(0.92, 0.92, 0.95);
const vec3 STRAND_ALBEDO = vec3(0.70, 0.42, 0.20);

// Light that a surface reflects from one light, given the visibility of each color. Lambert, two-sided.
vec3 light_on_surface(Light light, vec3 position, vec3 normal, vec3 visibility) {
    float cosine = abs(dot(normal, light_direction(light, position)));
    return light_radiance(light, position) * cosine * visibility;
}

// `light` is the sum over all lights and ambient light, here and below.
vec3 shade_surface(vec3 albedo, vec3 light) { return albedo * light; }

// Single scattering with an isotropic phase function, normalized so that a fully lit dense medium has the color of its albedo.
vec3 shade_caster(vec3 albedo, vec3 light) { return albedo * light; }

// The color of casters without their own color.
vec3 caster_albedo(Caster caster) { return caster_is_strand(caster) ? STRAND_ALBEDO : PARTICLE_ALBEDO; }

// A sheet looks up its light this share of its radius in front of itself. Twin: reference::truth::picture::SHEET_LIFT.
const float SHEET_LIFT = 1.0 / 16.0;

// Position at which to look up the light that reaches `position` of a caster. A strand absorbs its light in one step of depth. Its own
// points are at the edge of that step and would be shadowed at random. So a strand looks up light one width in front of itself, towards the
// light; so does a sheet. A splat is a piece of a surface. It looks up light in front of its whole extent and of the neighbours that it overlaps.
vec3 lit_side(Light light, Caster caster, vec3 position) {
    if (caster_is_splat(caster)) {
        vec3 towards = light_direction(light, position);
        SplatRay along = splat_ray(Ray(position, towards), caster.position, caster.radius, caster.axis);
        return position + max(SPLAT_REACH * along.deviation, caster.radius / SPLAT_REACH) * towards;
    }
    if (caster_is_sheet(caster)) {
        return position + SHEET_LIFT * caster.radius * light_direction(light, position);
    }
    return caster_is_strand(caster) ? position + 2.0 * caster.radius * light_direction(light, position) : position;
}
#endif
