// The segment of a camera ray inside a caster, and the color of that segment.
#ifndef CONSUME_CASTER_SEEN_GLSL
#define CONSUME_CASTER_SEEN_GLSL
#include "query/colored.glsl"
#include "shading/shading.glsl"

// Sets z to where the ray enters and leaves the caster, clipped to the near plane and to the mesh at `farthest`. False if the ray sees
// nothing of the caster.
bool caster_seen(View camera, Ray ray, Caster caster, float farthest, out vec2 z) {
    vec3 within;
    bool hit = caster_overlap(ray, caster, within);
    z = vec2(max(within.x, camera.near), min(within.y, farthest));
    return hit && z.y >= z.x;
}

// A caster's albedo; splats, sheets and volumes have their own colors. Needs PICTURE_SPLATS.
vec3 caster_color_of(Caster caster, uint index) {
    if (!caster_is_splat_or_cell(caster) && !caster_is_sheet(caster)) {
        return caster_albedo(caster);
    }
    uint at = 1u + 3u * (index - splats[0]);
    return uintBitsToFloat(uvec3(splats[at], splats[at + 1u], splats[at + 2u]));
}

// Premultiplied color of the part of a caster from z.x to z.y.
vec4 caster_color(Ray ray, Caster caster, vec3 albedo, vec2 z, vec3 light) {
    vec3 opacity = 1.0 - exp(-caster_optical_depth(ray, caster, z) * extinction_ratio());
    return blended_color(shade_caster(albedo, light) * opacity, opacity);
}
#endif
