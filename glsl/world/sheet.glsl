// Sheets: see-through triangles as casters. Neighbours share an edge so that each ray crosses exactly one of them. Define ALPHA_TRIANGLES,
// and ALPHA_ROWS if its elements are TriangleRows: see glsl/world/alpha.glsl. Source: ours; the edges after Woop et al. 2013, ties after
// Edelsbrunner and Mücke 1990, Simulation of Simplicity. Twin: reference::twin::sheet, scene::model::sheet.
#ifndef WORLD_SHEET_GLSL
#define WORLD_SHEET_GLSL
#include "world/alpha.glsl"
#include "world/caster.glsl"
#include "world/shear.glsl"
#ifdef ALPHA_ROWS
#include "world/triangle_rows.glsl"
#endif

// Number of the sheet's triangle.
uint sheet_triangle(Caster sheet) {
    return (floatBitsToUint(sheet.axis.x) & 0xFFFFu) << 16u | floatBitsToUint(sheet.axis.y) & 0xFFFFu;
}

// Corners of the sheet's triangle.
vec3[3] sheet_corners(Caster sheet) {
#ifdef ALPHA_ROWS
    return triangle_corners(ALPHA_TRIANGLES[sheet_triangle(sheet)]);
#else
    return ALPHA_TRIANGLES[sheet_triangle(sheet)].corners;
#endif
}

// The greatest optical depth of the triangle, for light of no color in particular.
float sheet_most(Caster sheet) { return sheet.axis.z; }

// Returns whether the ray, at the origin, is to the left of an edge. If it is on the edge, it is on the side on which it would be a tiny
// step down and a much tinier step to the left of here. Reversed, the edge has the ray on its other side.
bool side_is_left(vec2 from, vec2 to, float area) {
    if (area != 0.0) {
        return area > 0.0;
    }
    return from.x != to.x ? from.x < to.x : from.y < to.y;
}

// Optical depth of the sheet at a point of its triangle, as a share of its greatest. `at`: see alpha_value.
float sheet_share(Caster sheet, vec2 at) {
    Alpha alpha = alpha_record(max(alpha_number(sheet_triangle(sheet)), 1u));
    if (alpha.texels == 0u && alpha.factors[0] == alpha.factors[1] && alpha.factors[0] == alpha.factors[2]) {
        return 1.0;
    }
    float left = 1.0 - clamp(alpha_value(alpha, at), 0.0, 1.0);
    float optical_depth = left > 0.0 ? min(-log(left), MAX_OPTICAL_DEPTH) : MAX_OPTICAL_DEPTH;
    // The greatest comes from the host, which rounds otherwise.
    return min(optical_depth / sheet_most(sheet), 1.0);
}

bool sheet_overlap(vec3 origin, Ray ray, Caster sheet, out vec3 z) {
    z = vec3(0.0);
    vec3 corners[3] = sheet_corners(sheet);
    Shear shear = shear_of(ray.origin, ray.direction);
    vec3 a = sheared(shear, corners[0] - origin), b = sheared(shear, corners[1] - origin), c = sheared(shear, corners[2] - origin);
    vec2 low = min(a.xy, min(b.xy, c.xy)), high = max(a.xy, max(b.xy, c.xy));
    // Tests bounds first: if a sliver is far from the ray, the areas below are mostly rounding error.
    if (any(greaterThan(low, vec2(0.0))) || any(lessThan(high, vec2(0.0)))) {
        return false;
    }
    float u = side_area(b.xy, c.xy), v = side_area(c.xy, a.xy), w = side_area(a.xy, b.xy), area = u + v + w;
    bool left = side_is_left(b.xy, c.xy, u);
    if (left != side_is_left(c.xy, a.xy, v) || left != side_is_left(a.xy, b.xy, w) || area == 0.0) {
        return false;
    }
    float at = (u * a.z + v * b.z + w * c.z) / area;
    z = vec3(at, at, sheet_share(sheet, vec2(v, w) / area));
    return z.z > 0.0;
}

// The z at which a ray crosses the plane of a sheet's triangle, within the sphere around it. The ray is given relative to `origin`.
float sheet_plane(vec3 origin, Ray ray, Caster sheet) {
    vec3 corners[3] = sheet_corners(sheet);
    vec3 normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    float along = dot(normal, ray.direction), from = dot(normal, corners[0] - origin - ray.origin);
    float square = dot(ray.direction, ray.direction), middle = dot(sheet.position - origin - ray.origin, ray.direction) / square;
    float reach = sheet.radius * inversesqrt(square);
    // A ray along the plane crosses it anywhere.
    float at = abs(from) < abs(along) * 1e9 ? from / along : middle;
    return clamp(at, middle - reach, middle + reach);
}
#endif
