// The segment that a particle cuts out of the light ray through a texel centre, in the light's range.
#ifndef LIST_TEXEL_SEGMENT_GLSL
#define LIST_TEXEL_SEGMENT_GLSL
#include "common/light.glsl"
#include "common/particle.glsl"

// False where the ray misses the particle or leaves it before the light's near plane.
bool texel_segment(View view, uvec2 texel, Particle particle, out vec2 depth, out float optical_depth) {
    Ray ray = view_ray(view, vec2(texel) + 0.5);
    vec2 z;
    depth = vec2(0.0);
    optical_depth = 0.0;
    if (!particle_overlap(ray, particle, z) || z.y <= view.near) {
        return false;
    }
    z.x = max(z.x, view.near);
    optical_depth = particle.extinction * (z.y - z.x) * length(ray.direction);
    if (optical_depth > MAX_OPTICAL_DEPTH) {
        // Cut off where nothing is left, so that the light fades as fast as it should.
        z.y = z.x + (z.y - z.x) * (MAX_OPTICAL_DEPTH / optical_depth);
        optical_depth = MAX_OPTICAL_DEPTH;
    }
    depth = vec2(view_depth(view, z.x), view_depth(view, z.y));
    return true;
}
#endif
