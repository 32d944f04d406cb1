// Rays in the axes of a view, and where they hit casters there.
#ifndef MAPS_BINS_VIEW_CASTER_GLSL
#define MAPS_BINS_VIEW_CASTER_GLSL
#include "maps/segment.glsl"

// view_ray through a texel's centre, in the view's axes.
Ray view_texel_ray(View view, uvec2 texel) {
    vec2 ndc = (vec2(texel) + 0.5) / vec2(view.width, view.height) * 2.0 - 1.0;
    vec2 across = ndc / vec2(view.scale_x, view.scale_y);
    return view.projection == VIEW_PARALLEL ? Ray(vec3(across, 0.0), vec3(0.0, 0.0, 1.0))
                                            : Ray(vec3(0.0), vec3(across, 1.0));
}

// A ray of view_texel_ray, moved to the right by `right`, which is measured in the plane z = 0 for parallel rays, else in the plane z = 1.
Ray view_ray_beside(View view, Ray ray, float right) {
    if (view.projection == VIEW_PARALLEL) {
        ray.origin.x += right;
    } else {
        ray.direction.x += right;
    }
    return ray;
}

// A ray in the view's axes, turned into those of the world; relative to the view's origin.
Ray world_ray(View view, Ray ray) {
    vec3 origin = ray.origin.x * view.right + ray.origin.y * view.up + ray.origin.z * view.forward;
    vec3 direction = ray.direction.x * view.right + ray.direction.y * view.up + ray.direction.z * view.forward;
    return Ray(origin, direction);
}

// Whether the ray may hit the caster. If this returns false, so does view_segment, however either is rounded.
bool view_meets(View view, Ray ray, float ray_length, Caster caster) {
    if (caster_is_strand(caster)) {
        return true;
    }
    float radius = 1.00001 * caster.radius;
    vec3 across = vec3(caster.position.xy - ray.origin.xy, 0.0);
    if (view.projection != VIEW_PARALLEL) {
        across = caster.position - dot(caster.position, ray.direction) / (ray_length * ray_length) * ray.direction;
        radius += 1e-6 * ray_length * abs(caster.position.z);
    }
    return dot(across, across) < radius * radius;
}

// Whether every ray that hits the caster crosses it along a full chord, without clipping: true for a sphere entirely behind the near plane,
// in a parallel view.
bool plain_sphere(View view, Caster caster) {
    return view.projection == VIEW_PARALLEL && caster_is_sphere(caster) && caster.position.z - caster.radius >= view.near;
}

// Same as texel_segment, for a ray and a caster in the view's axes.
bool view_segment(View view, Ray ray, float ray_length, Caster caster, float dark, out vec2 z, out float optical_depth) {
    bool hit;
    vec3 within;
    if (view.projection == VIEW_PARALLEL && caster_is_sphere(caster)) {
        // caster_overlap for a ray with direction (0, 0, 1).
        vec2 across = caster.position.xy - ray.origin.xy;
        float half_square = caster.radius * caster.radius - dot(across, across);
        float half_chord = sqrt(max(half_square, 0.0));
        within = vec3(caster.position.z - half_chord, caster.position.z + half_chord, 2.0 * half_chord);
        hit = half_square > 0.0 && within.y > view.near;
    } else if (caster_is_sheet(caster)) {
        hit = sheet_overlap(view.origin, world_ray(view, ray), caster, within) && within.y > view.near;
    } else {
        hit = caster_overlap(ray, caster, within) && within.y > view.near;
    }
    optical_depth = segment_cut(view, ray_length, caster, dark, within);
    z = within.xy;
    return hit;
}
#endif
