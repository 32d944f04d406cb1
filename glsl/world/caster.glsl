// Translucent casters: a sphere of constant extinction, a splat, a cell of a volume, a strand, or a sheet. A strand is a line segment with
// the width of a ribbon that faces every ray; a sheet is a see-through triangle (glsl/world/sheet.glsl). Also their overlap with a ray, and
// the quad that covers them. Twin: scene::Caster, reference::twin::segment, reference::truth.
#ifndef WORLD_CASTER_GLSL
#define WORLD_CASTER_GLSL
#include "world/cell.glsl"
#include "world/splat.glsl"
#include "world/view.glsl"

struct Caster {
    vec3 position;  // a sphere's centre, a strand's start, the centre of a sphere around a sheet
    float radius;   // 0 for an unused entry past a count that only the device knows: it casts no shadow
    vec3 axis;      // from a strand's start to its end; 0 for a sphere; for a splat or a cell, bits of its shape; for a sheet, of its number
    float density;  // extinction of a sphere or a cell, or at a splat's centre, 1 / world unit; optical depth of a strand, a sheet's greatest
};

// False leaves out the arithmetic of strands, for scenes without any.
CONSTANT(bool, STRANDS, true)
// False leaves out the arithmetic of splats and cells, for scenes without splats and volumes.
CONSTANT(bool, SPLATS_OR_CELLS, true)
// False leaves out the arithmetic of sheets, for scenes without see-through meshes.
CONSTANT(bool, SHEETS, true)

// Bits of the axis that mark a caster as a sheet. Twin: MARK in scene::model::sheet.
const uint SHEET_MARK = 0x72800000u;

bool caster_is_splat(Caster caster) {
    return SPLATS_OR_CELLS && splat_marked(caster.axis);
}

bool caster_is_cell(Caster caster) {
    return SPLATS_OR_CELLS && cell_marked(caster.axis);
}

// Whether the caster is a splat or a cell: both have their shape packed into the axis.
bool caster_is_splat_or_cell(Caster caster) { return caster_is_splat(caster) || caster_is_cell(caster); }

bool caster_is_sheet(Caster caster) {
    return SHEETS && (floatBitsToUint(caster.axis.x) & 0x7F800000u) == SHEET_MARK;
}

bool caster_is_strand(Caster caster) {
    return STRANDS && any(notEqual(caster.axis, vec3(0.0))) && !caster_is_splat_or_cell(caster) && !caster_is_sheet(caster);
}

bool caster_is_sphere(Caster caster) {
    return !caster_is_strand(caster) && !caster_is_splat_or_cell(caster) && !caster_is_sheet(caster);
}

// Whether rays lose light to the caster in a single step, without a length.
bool caster_is_step(Caster caster) { return caster_is_strand(caster) || caster_is_sheet(caster); }

// Vector from a strand's start to its end; 0 for other casters.
vec3 caster_axis(Caster caster) {
    return caster_is_strand(caster) ? caster.axis : vec3(0.0);
}

// Whether `a` comes after `b` when casters are ordered by their values, regardless of where they are listed. False in either order for
// equal casters.
bool caster_after(Caster a, Caster b) {
    vec4 all_a[2] = { vec4(a.position, a.radius), vec4(a.axis, a.density) };
    vec4 all_b[2] = { vec4(b.position, b.radius), vec4(b.axis, b.density) };
    for (uint i = 0u; i < 8u; ++i) {
        float of_a = all_a[i >> 2u][i & 3u], of_b = all_b[i >> 2u][i & 3u];
        if (of_a != of_b) {
            return of_a > of_b;
        }
    }
    return false;
}

// Upper bound of the caster's optical depth along any ray. For a splat the exact maximum is 0.84 times the extinction at its centre times
// its radius.
float caster_most(Caster caster) {
    return caster_is_step(caster) ? caster.density : 2.0 * caster.radius * caster.density;
}

// Optical depth from which a caster counts as opaque: exp(-80) is still a normal float, and sums over many casters stay finite.
const float MAX_OPTICAL_DEPTH = 80.0;
// Optical depth from which no light is left: exp(-16) is about a ten-millionth.
const float DARK = 16.0;

// Squared sine of the angle between ray and axis below which a ribbon counts as edge-on: it then has no width, and no single point of its
// axis is nearest to the ray.
const float EDGE_ON = 1e-10;

// Finds where the axis comes nearest to the ray: 0 at the strand's start, 1 at its end, not clamped. `start` and `axis` are the strand's
// start and axis without their components along the ray, so that start + along · axis is the offset from the ray. Returns false if the
// strand is edge-on.
bool strand_along(Ray ray, Caster strand, out vec3 start, out vec3 axis, out float along) {
    float scale = 1.0 / dot(ray.direction, ray.direction);
    vec3 offset = strand.position - ray.origin;
    start = offset - dot(offset, ray.direction) * scale * ray.direction;
    axis = strand.axis - dot(strand.axis, ray.direction) * scale * ray.direction;
    float square = dot(axis, axis);
    along = -dot(start, axis) / square;
    return square > EDGE_ON * dot(strand.axis, strand.axis);
}

// A strand absorbs its light in a single step, z.x = z.y, at the point of its axis nearest to the ray. Its start belongs to the strand and
// its end does not, so that the joint of two strands counts once.
bool strand_overlap(Ray ray, Caster strand, out vec3 z) {
    vec3 start, axis;
    float along;
    z = vec3(0.0);
    if (!strand_along(ray, strand, start, axis, along) || !(along >= 0.0 && along < 1.0)) {
        return false;
    }
    vec3 across = start + along * axis;
    vec3 offset = strand.position - ray.origin;
    z.xy = vec2((dot(offset, ray.direction) + along * dot(strand.axis, ray.direction)) / dot(ray.direction, ray.direction));
    z.z = 1.0;
    return dot(across, across) < strand.radius * strand.radius;
}

// Returns the segment of constant extinction that approximates a splat, within the splat's reach. z.z is the length over which the
// extinction at the splat's centre gives the same optical depth.
bool splat_overlap(Ray ray, Caster caster, out vec3 z) {
    SplatRay along = splat_ray(ray, caster.position, caster.radius, caster.axis);
    float half_chord = min(SPLAT_CHORD * along.deviation, splat_half(along));
    z = vec3(along.middle - half_chord, along.middle + half_chord, splat_length(along));
    return half_chord > 0.0;
}

// A sheet absorbs its light in a single step, z.x = z.y, where the ray crosses the triangle. z.z is the share of its greatest optical depth
// that it has there. The ray is given relative to `origin`, so that far from the world's origin nothing is rounded to the coarse steps of
// floats there. Defined in glsl/world/sheet.glsl, which needs the triangles: a shader that asks for casters' overlap has to have them.
bool sheet_overlap(vec3 origin, Ray ray, Caster sheet, out vec3 z);

// Returns where the ray is inside the caster: from z.x to z.y, with length z.z; for a step, z.z is a share of `density`. For a small,
// distant sphere, the difference z.y − z.x would lose the length to rounding. The offset from the ray is squared after the subtraction, so that a far origin costs no precision.
bool caster_overlap(Ray ray, Caster caster, out vec3 z) {
    if (caster_is_strand(caster)) {
        return strand_overlap(ray, caster, z);
    }
    if (caster_is_sheet(caster)) {
        return sheet_overlap(vec3(0.0), ray, caster, z);
    }
    if (caster_is_splat(caster)) {
        return splat_overlap(ray, caster, z);
    }
    if (caster_is_cell(caster)) {
        return cell_overlap(ray, caster.position, caster.radius, caster.axis, z);
    }
    vec3 offset = caster.position - ray.origin;
    float scale = 1.0 / dot(ray.direction, ray.direction);
    float middle = dot(offset, ray.direction) * scale;
    vec3 across = offset - middle * ray.direction;
    float half_square = (caster.radius * caster.radius - dot(across, across)) * scale;
    if (!(half_square > 0.0)) {
        z = vec3(0.0);
        return false;
    }
    float half_chord = sqrt(half_square);
    z = vec3(middle - half_chord, middle + half_chord, 2.0 * half_chord);
    return true;
}

// Factor that turns a caster's density into its optical depth from z.x to z.y, an interval inside the caster.
float caster_thickness(Ray ray, Caster caster, vec2 z) {
    float thickness = caster_is_strand(caster) ? 1.0 : (z.y - z.x) * length(ray.direction);
    if (caster_is_sheet(caster)) {
        vec3 step;
        caster_overlap(ray, caster, step);
        return step.z;
    }
    if (caster_is_splat(caster)) {
        vec3 within;
        caster_overlap(ray, caster, within);
        thickness *= within.z / (within.y - within.x);
    }
    return thickness;
}

// Optical depth from z.x to z.y, an interval inside the caster.
float caster_optical_depth(Ray ray, Caster caster, vec2 z) {
    return min(caster.density * caster_thickness(ray, caster, z), MAX_OPTICAL_DEPTH);
}

// Range of tan(angle) covered by a circle of radius r at (across, z), as seen from the origin; the whole range if the circle reaches behind
// the eye.
vec2 sphere_tangents(float across, float z, float radius) {
    if (z <= radius) {
        return vec2(-1e9, 1e9);
    }
    float side = sqrt(max(across * across + z * z - radius * radius, 0.0));
    return vec2((across * side - radius * z) / (z * side + radius * across),
                (across * side + radius * z) / (z * side - radius * across));
}

// Extent of a sphere about `centre`, given in the view's axes: low to high along right (x, y) and along up (z, w), in world units for a
// parallel view, as tangents in perspective.
vec4 sphere_extent(View view, vec3 centre, float radius) {
    return view.projection == VIEW_PERSPECTIVE
               ? vec4(sphere_tangents(centre.x, centre.z, radius), sphere_tangents(centre.y, centre.z, radius))
               : vec4(centre.x - radius, centre.x + radius, centre.y - radius, centre.y + radius);
}

vec3 view_axes(View view, vec3 offset) {
    return vec3(dot(offset, view.right), dot(offset, view.up), dot(offset, view.forward));
}

// Transforms a caster into the view's axes, so that values shared by all texels are computed once per caster. Distances and z stay the
// same.
Caster view_caster(View view, Caster caster) {
    caster.position = view_axes(view, caster.position - view.origin);
    if (caster_is_strand(caster)) {
        caster.axis = view_axes(view, caster.axis);
    }
    if (caster_is_splat_or_cell(caster)) {
        caster.axis = splat_turned(view, caster.axis);
    }
    return caster;
}

// Bounds in NDC of a caster given in the view's axes, low and high corner; false if the caster is behind the view. They are a 16th of a
// texel too large, as a margin for rounding: drawing and binning make the exact decision later.
bool view_caster_bounds(View view, Caster caster, out vec2 low, out vec2 high) {
    vec4 extent = caster_is_splat(caster) ? splat_extent(view, caster.position, caster.radius, caster.axis)
                                             : sphere_extent(view, caster.position, caster.radius);
    float farthest = caster.position.z;
    if (caster_is_cell(caster) && view.projection != VIEW_PERSPECTIVE) {
        extent = cell_extent(caster.position, caster.radius, caster.axis);
    }
    if (caster_is_strand(caster)) {
        // A strand is contained in the convex hull of the spheres about its ends.
        vec3 end = caster.position + caster.axis;
        vec4 other = sphere_extent(view, end, caster.radius);
        extent = vec4(min(extent.x, other.x), max(extent.y, other.y), min(extent.z, other.z), max(extent.w, other.w));
        farthest = max(farthest, end.z);
    }
    low = high = vec2(2.0);
    if (caster.radius == 0.0) {
        return false;
    }
    if (view.projection == VIEW_PERSPECTIVE && farthest + caster.radius <= view.near) {
        return false;
    }
    vec2 x = extent.xy * view.scale_x;
    vec2 y = extent.zw * view.scale_y;
    vec2 margin = 0.125 / vec2(view.width, view.height);
    low = vec2(min(x.x, x.y), min(y.x, y.y)) - margin;
    high = vec2(max(x.x, x.y), max(y.x, y.y)) + margin;
    return true;
}

// Bounds in NDC of a caster given in world space.
bool caster_bounds(View view, Caster caster, out vec2 low, out vec2 high) {
    return view_caster_bounds(view, view_caster(view, caster), low, high);
}

// Corner 0..5 of the two triangles that cover the caster's bounds.
vec4 caster_corner(View view, Caster caster, uint corner) {
    vec2 low, high;
    if (!caster_bounds(view, caster, low, high)) {
        return vec4(2.0, 2.0, 0.0, 1.0);
    }
    vec2 select = vec2(corner == 1u || corner == 2u || corner == 4u, corner == 2u || corner == 4u || corner == 5u);
    return vec4(clamp(mix(low, high, select), -1.1, 1.1), 0.5, 1.0);
}
#endif
