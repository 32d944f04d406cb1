// The part of a light ray inside a caster, as depths and optical depth; for a strand or a sheet it has no length. Twin:
// reference::twin::segment.
#ifndef MAPS_SEGMENT_GLSL
#define MAPS_SEGMENT_GLSL
#include "world/caster.glsl"
#include "world/light.glsl"

// Clips the interval of a ray inside a caster, as returned by caster_overlap (z.y > near). The interval is cut at the near plane, and at an
// optical depth of `dark`, behind which no light is left. Up to there the light fades as in the whole caster. `ray_length`: length of the
// ray's direction. Returns the optical depth of the interval.
float segment_cut(View view, float ray_length, Caster caster, float dark, inout vec3 z) {
    if (caster_is_step(caster)) {
        return min(caster.density * z.z, dark);
    }
    if (z.x < view.near) {
        z.z = caster_is_splat(caster) ? z.z * ((z.y - view.near) / (z.y - z.x)) : z.y - view.near;
        z.x = view.near;
    }
    float optical_depth = caster.density * z.z * ray_length;
    if (optical_depth > dark) {
        z.z *= dark / optical_depth;
        z.y = z.x + (caster_is_splat(caster) ? (z.y - z.x) * (dark / optical_depth) : z.z);
        optical_depth = dark;
    }
    return optical_depth;
}

// The segment of the ray through a texel's centre, as depths in the light's range. False if the ray misses the caster or leaves it before
// the near plane.
bool texel_segment(View view, uvec2 texel, Caster caster, out vec2 depth, out float optical_depth) {
    // Relative to the view's origin: far from the world's origin, a ray's origin would be rounded to the coarse steps of floats there.
    caster.position -= view.origin;
    View about = view;
    about.origin = vec3(0.0);
    Ray ray = view_ray(about, vec2(texel) + 0.5);
    vec3 z;
    depth = vec2(0.0);
    optical_depth = 0.0;
    bool hit = caster_is_sheet(caster) ? sheet_overlap(view.origin, ray, caster, z) : caster_overlap(ray, caster, z);
    if (!hit || z.y <= view.near) {
        return false;
    }
    optical_depth = segment_cut(view, length(ray.direction), caster, MAX_OPTICAL_DEPTH, z);
    depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
    return true;
}
#endif
