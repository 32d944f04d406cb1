// Optical depth of a caster along a ray, from the ray's origin to an end. Twin: the truth, in f64.
#ifndef WORLD_CAST_DEPTH_GLSL
#define WORLD_CAST_DEPTH_GLSL
#include "world/caster.glsl"

// cast_depth of a splat, from its true profile and not from the segment that approximates it. If the end is in front of the splat's reach,
// the result is 0; if it is behind the reach, the result is the optical depth of the entire splat.
float splat_cast_depth(Ray ray, float ray_length, Caster caster, float end, out float entry) {
    SplatRay along = splat_ray(ray, caster.position, caster.radius, caster.axis);
    float half_chord = splat_half(along), low = along.middle - half_chord, high = along.middle + half_chord;
    entry = max(low, 0.0);
    if (!(half_chord > 0.0 && entry <= min(high, end))) {
        return 0.0;
    }
    float before = low >= 0.0 ? 0.0 : splat_share(-along.middle / along.deviation);
    float upto = high <= end ? 1.0 : splat_share((end - along.middle) / along.deviation);
    return min(caster.density * splat_length(along) * ray_length * max(upto - before, 0.0), MAX_OPTICAL_DEPTH);
}

// Returns the caster's optical depth on the ray from 0 to `end`, both in lengths of the ray's direction. A strand whose step is exactly at
// either end counts. `entry`: where the ray enters the caster, or 0 if the ray starts inside.
float cast_depth(Ray ray, float ray_length, Caster caster, float end, out float entry) {
    vec3 z;
    if (caster_is_splat(caster)) {
        return splat_cast_depth(ray, ray_length, caster, end, entry);
    }
    entry = 0.0;
    if (!caster_overlap(ray, caster, z)) {
        return 0.0;
    }
    entry = max(z.x, 0.0);
    float leave = min(z.y, end);
    if (!(entry <= leave)) {
        return 0.0;
    }
    // For an unclipped chord, z.z is more precise than the difference.
    float inside = entry == z.x && leave == z.y ? z.z : leave - entry;
    return min(caster.density * (caster_is_step(caster) ? z.z : inside * ray_length), MAX_OPTICAL_DEPTH);
}
#endif
