// The segment that a caster cuts out of the light ray through a texel centre, in the light's range; a strand's has no
// length.
#ifndef LIST_TEXEL_SEGMENT_GLSL
#define LIST_TEXEL_SEGMENT_GLSL
#include "common/light.glsl"
#include "common/caster.glsl"

// False where the ray misses the caster or leaves it before the light's near plane.
bool texel_segment(View view, uvec2 texel, Caster caster, out vec2 depth, out float optical_depth) {
    Ray ray = view_ray(view, vec2(texel) + 0.5);
    vec2 z;
    depth = vec2(0.0);
    optical_depth = 0.0;
    if (!caster_overlap(ray, caster, z) || z.y <= view.near) {
        return false;
    }
    if (caster_is_strand(caster)) {
        depth = vec2(view_depth(view, z.x));
        optical_depth = caster.density;
        return true;
    }
    z.x = max(z.x, view.near);
    optical_depth = caster.density * (z.y - z.x) * length(ray.direction);
    if (optical_depth > MAX_OPTICAL_DEPTH) {
        // Cut off where nothing is left, so that the light fades as fast as it should.
        z.y = z.x + (z.y - z.x) * (MAX_OPTICAL_DEPTH / optical_depth);
        optical_depth = MAX_OPTICAL_DEPTH;
    }
    depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
    return true;
}
#endif
