// The segment that a caster cuts out of a light ray; a strand's has no length. Twin: reference::twin::segment.
#ifndef MAPS_SEGMENT_GLSL
#define MAPS_SEGMENT_GLSL
#include "world/caster.glsl"
#include "world/light.glsl"

// Of what a ray is inside a caster from z.x to z.y: cut off at the near plane, and where an optical depth of `dark` is
// reached, since nothing is left behind it; the light fades as fast as it should. False where nothing is left of it.
// `ray_length` is that of the ray's direction.
bool segment_cut(View view, float ray_length, Caster caster, float dark, bool hit, inout vec2 z, out float optical_depth) {
    hit = hit && z.y > view.near;
    if (caster_is_strand(caster)) {
        optical_depth = caster.density;
    } else {
        z.x = max(z.x, view.near);
        optical_depth = caster.density * (z.y - z.x) * ray_length;
    }
    if (optical_depth > dark) {
        z.y = z.x + (z.y - z.x) * (dark / optical_depth);
        optical_depth = dark;
    }
    return hit;
}

// Through a texel's centre, as depths in the light's range.
bool texel_segment(View view, uvec2 texel, Caster caster, out vec2 depth, out float optical_depth) {
    Ray ray = view_ray(view, vec2(texel) + 0.5);
    vec2 z;
    bool hit = caster_overlap(ray, caster, z);
    hit = segment_cut(view, length(ray.direction), caster, MAX_OPTICAL_DEPTH, hit, z, optical_depth);
    depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
    return hit;
}
#endif
