// The segment that a caster leaves in a texel: that of the ray through its centre, or with AREA what lets as much light
// through as the mean of all rays through the texel. Each caster is averaged alone: which of the rays that one meets
// another meets too is left to chance, as where hairs cross.
// Source: ours. Twin: reference::twin::area.
#ifndef MAPS_BINS_AREA_GLSL
#define MAPS_BINS_AREA_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/bins/texel.glsl"
#include "maps/bins/view_caster.glsl"

// Spheres of so many texels' radius have no edge that a ray could miss; of smaller ones SPHERE_RAYS² rays are looked at.
const float WIDE = 2.0;
const uint SPHERE_RAYS = 4u;
// Lines on which a texel's share of a ribbon is measured.
const uint COLUMNS = 8u;

// What share of the light an optical depth takes, and back; of little the differences from 1 would be rounding.
float share_taken(float optical_depth) {
    return optical_depth < 1e-3 ? optical_depth - 0.5 * optical_depth * optical_depth : 1.0 - exp(-optical_depth);
}

float optical_depth_of(float taken) {
    return taken < 1e-3 ? taken + 0.5 * taken * taken : -log(1.0 - taken);
}

// Share of the texel about the ray that the ribbon covers: on COLUMNS lines across the texel, along that side of it which is
// more across the ribbon, the part between the ribbon's edges and ends.
bool strand_share(View view, Ray ray, Caster strand, out float z, out float share) {
    vec3 start, axis;
    float along, square = dot(ray.direction, ray.direction);
    z = share = 0.0;
    if (!strand_along(ray, strand, start, axis, along)) {
        return false;
    }
    vec3 point = strand.position - ray.origin + clamp(along, 0.0, 1.0) * strand.axis;
    z = dot(point, ray.direction) / square;
    // Along the ribbon and across it, both across the ray.
    float extent = length(axis);
    vec3 u = axis / extent, v = cross(u, ray.direction * inversesqrt(square));
    vec2 sides = texel_sides(view, z), on_u = sides * u.xy, on_v = sides * v.xy;
    float middle = dot(start, v);
    if (abs(middle) > strand.radius + 0.5 * (abs(on_v.x) + abs(on_v.y))) {
        // Most texels of a tile are beside the ribbon: none of the lines meets it.
        return false;
    }
    if (abs(on_v.x) > abs(on_v.y)) {
        on_u = on_u.yx;
        on_v = on_v.yx;
    }
    float per_u = 1.0 / (on_u.y + (on_u.y < 0.0 ? -1e-9 : 1e-9)), per_v = 1.0 / on_v.y;
    float from = dot(start, u), half_wide = strand.radius * abs(per_v);
    [[unroll]] for (uint i = 0u; i < COLUMNS; ++i) {
        float at = (float(i) + 0.5) / float(COLUMNS) - 0.5;
        float centre = (middle - at * on_v.x) * per_v;
        vec2 ends = (vec2(from, from + extent) - at * on_u.x) * per_u;
        float low = max(max(centre - half_wide, min(ends.x, ends.y)), -0.5);
        float high = min(min(centre + half_wide, max(ends.x, ends.y)), 0.5);
        share += max(high - low, 0.0) / float(COLUMNS);
    }
    return share > 0.0 && z > view.near;
}

// The mean of rays through the texel about `ray`; from where the first begins to where the last ends.
bool sphere_mean(View view, Ray ray, Caster sphere, float dark, out vec2 z, out float taken) {
    vec2 sides = texel_sides(view, 1.0);
    z = vec2(FARTHEST, -FARTHEST);
    taken = 0.0;
    [[dont_unroll]] for (uint i = 0u; i < SPHERE_RAYS * SPHERE_RAYS; ++i) {
        vec2 beside = ((vec2(i % SPHERE_RAYS, i / SPHERE_RAYS) + 0.5) / float(SPHERE_RAYS) - 0.5) * sides, its;
        Ray other = ray;
        if (view.projection == VIEW_PARALLEL) {
            other.origin.xy += beside;
        } else {
            other.direction.xy += beside;
        }
        float optical_depth;
        if (view_segment(view, other, length(other.direction), sphere, dark, its, optical_depth)) {
            z = vec2(min(z.x, its.x), max(z.y, its.y));
            taken += share_taken(optical_depth) / float(SPHERE_RAYS * SPHERE_RAYS);
        }
    }
    return taken > 0.0;
}

// As view_segment.
bool texel_part(View view, Ray ray, float ray_length, Caster caster, float dark, out vec2 z, out float optical_depth) {
    float share = 1.0, taken = 0.0, at;
    if (AREA && caster_is_strand(caster)) {
        bool hit = strand_share(view, ray, caster, at, share);
        z = vec2(at);
        optical_depth = min(caster.density, dark);
        taken = share * share_taken(optical_depth);
        optical_depth = taken < 0.999999 ? min(optical_depth_of(taken), optical_depth) : optical_depth;
        return hit;
    }
    if (AREA) {
        vec2 sides = texel_sides(view, max(caster.position.z, view.near));
        // A Gaussian's radius says nothing of how thin it is, nor does a cell's.
        if (caster.radius < WIDE * max(sides.x, sides.y) || caster_is_packed(caster)) {
            bool hit = sphere_mean(view, ray, caster, dark, z, taken);
            optical_depth = taken < 0.999999 ? min(optical_depth_of(taken), dark) : dark;
            return hit;
        }
    }
    return view_segment(view, ray, ray_length, caster, dark, z, optical_depth);
}
#endif
