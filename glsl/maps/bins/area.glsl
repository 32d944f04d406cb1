// The segment that a caster leaves in a texel. Without AREA it is the segment of the ray through the texel's centre. With AREA it is a
// segment that transmits as much light as all rays through the texel do on average. texel_part averages each caster by itself: whether two
// casters cover the same part of the texel is left to chance. A shader that processes casters in order also calls area_seen, which tracks
// the light left in each of 4×4 cells of the texel. So strands in front of one another block the same light, and strands side by side do
// not. Source: ours; coverage by cells as in the A-buffer (Carpenter 1984), with fractions instead of bits. Twin: reference::twin::area.
#ifndef MAPS_BINS_AREA_GLSL
#define MAPS_BINS_AREA_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "maps/bins/texel.glsl"
#include "maps/bins/view_caster.glsl"

// A sphere with a radius of at least WIDE texels is sampled by one ray. A smaller sphere, which a single ray may miss, is averaged over
// SPHERE_RAYS² rays.
const float WIDE = 2.0;
const uint SPHERE_RAYS = 4u;
// Number of lines on which a ribbon's coverage of a texel is measured.
const uint COLUMNS = 8u;
// Number of cells along a side of a texel, each with one of a sphere's rays; and total number of cells.
const uint AREA_SIDE = SPHERE_RAYS;
const uint AREA_CELLS = AREA_SIDE * AREA_SIDE;

// Fraction of light that an optical depth absorbs; optical_depth_of is the inverse function. Small optical depths use a series, since 1
// minus a transmittance near 1 would be mostly rounding error.
float share_taken(float optical_depth) {
    return optical_depth < 1e-3 ? optical_depth - 0.5 * optical_depth * optical_depth : 1.0 - exp(-optical_depth);
}

float optical_depth_of(float taken) {
    return taken < 1e-3 ? taken + 0.5 * taken * taken : -log(1.0 - taken);
}

// A ribbon, which is a strand as the ray sees it, measured on parallel lines across a texel. The lines run along x (`turned`) or along y,
// whichever axis crosses the ribbon more steeply.
struct Lines {
    float z;
    float middle;
    float half_wide;
    vec2 ends;
    vec2 on_u;
    vec2 on_v;
    float per_u;
    float per_v;
    bool turned;
};

// False if none of the lines can cross the ribbon.
bool strand_lines(View view, Ray ray, Caster strand, out Lines lines) {
    vec3 start, axis;
    float along, square = dot(ray.direction, ray.direction);
    lines.z = 0.0;
    if (!strand_along(ray, strand, start, axis, along)) {
        return false;
    }
    vec3 point = strand.position - ray.origin + clamp(along, 0.0, 1.0) * strand.axis;
    lines.z = dot(point, ray.direction) / square;
    // u: along the ribbon; v: across it; both perpendicular to the ray.
    float extent = length(axis);
    vec3 u = axis / extent, v = cross(u, ray.direction * inversesqrt(square));
    vec2 sides = texel_sides(view, lines.z), on_u = sides * u.xy, on_v = sides * v.xy;
    lines.middle = dot(start, v);
    if (abs(lines.middle) > strand.radius + 0.5 * (abs(on_v.x) + abs(on_v.y))) {
        // Most texels of a tile do not touch the ribbon.
        return false;
    }
    lines.turned = abs(on_v.x) > abs(on_v.y);
    lines.on_u = lines.turned ? on_u.yx : on_u;
    lines.on_v = lines.turned ? on_v.yx : on_v;
    lines.per_u = 1.0 / (lines.on_u.y + (lines.on_u.y < 0.0 ? -1e-9 : 1e-9));
    lines.per_v = 1.0 / lines.on_v.y;
    float from = dot(start, u);
    lines.ends = vec2(from, from + extent);
    lines.half_wide = strand.radius * abs(lines.per_v);
    return true;
}

// Where line i enters and leaves the ribbon, between its edges and ends; the line itself runs from -0.5 to 0.5.
vec2 line_within(Lines lines, uint i) {
    float at = (float(i) + 0.5) / float(COLUMNS) - 0.5;
    float centre = (lines.middle - at * lines.on_v.x) * lines.per_v;
    vec2 ends = (lines.ends - at * lines.on_u.x) * lines.per_u;
    return vec2(max(max(centre - lines.half_wide, min(ends.x, ends.y)), -0.5),
                min(min(centre + lines.half_wide, max(ends.x, ends.y)), 0.5));
}

// Fraction of the texel around the ray that the ribbon covers.
bool strand_share(View view, Ray ray, Caster strand, out float z, out float share) {
    Lines lines;
    share = 0.0;
    bool near = strand_lines(view, ray, strand, lines);
    z = lines.z;
    if (!near) {
        return false;
    }
    [[unroll]] for (uint i = 0u; i < COLUMNS; ++i) {
        vec2 within = line_within(lines, i);
        share += max(within.y - within.x, 0.0) / float(COLUMNS);
    }
    return share > 0.0 && z > view.near;
}

// Fraction of each of the texel's cells that the ribbon covers, in rows along x.
void strand_cells(View view, Ray ray, Caster strand, out float shares[AREA_CELLS]) {
    const uint EACH = COLUMNS / AREA_SIDE;
    Lines lines;
    bool near = strand_lines(view, ray, strand, lines);
    float by_lines[AREA_CELLS];
    [[unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
        by_lines[i] = 0.0;
    }
    if (near) {
        [[unroll]] for (uint i = 0u; i < COLUMNS; ++i) {
            vec2 within = line_within(lines, i);
            [[unroll]] for (uint j = 0u; j < AREA_SIDE; ++j) {
                float low = float(j) / float(AREA_SIDE) - 0.5, high = float(j + 1u) / float(AREA_SIDE) - 0.5;
                by_lines[j * AREA_SIDE + i / EACH] +=
                    max(min(within.y, high) - max(within.x, low), 0.0) * (float(AREA_SIDE) / float(EACH));
            }
        }
    }
    [[unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
        shares[i] = near && lines.turned ? by_lines[i % AREA_SIDE * AREA_SIDE + i / AREA_SIDE] : by_lines[i];
    }
}

// The segment of the ray through the centre of cell i of the texel around `ray`.
bool sphere_part(View view, Ray ray, Caster sphere, float dark, uint i, out vec2 z, out float optical_depth) {
    vec2 sides = texel_sides(view, 1.0);
    vec2 beside = ((vec2(i % SPHERE_RAYS, i / SPHERE_RAYS) + 0.5) / float(SPHERE_RAYS) - 0.5) * sides;
    if (view.projection == VIEW_PARALLEL) {
        ray.origin.xy += beside;
    } else {
        ray.direction.xy += beside;
    }
    return view_segment(view, ray, length(ray.direction), sphere, dark, z, optical_depth);
}

// Averages a sphere over rays through the texel around `ray`. `taken`: the mean fraction of light that the sphere absorbs; `z`: from where
// the first ray enters the sphere to where the last one leaves it.
bool sphere_mean(View view, Ray ray, Caster sphere, float dark, out vec2 z, out float taken) {
    z = vec2(FARTHEST, -FARTHEST);
    taken = 0.0;
    [[dont_unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
        vec2 its;
        float optical_depth;
        if (sphere_part(view, ray, sphere, dark, i, its, optical_depth)) {
            z = vec2(min(z.x, its.x), max(z.y, its.y));
            taken += share_taken(optical_depth) / float(AREA_CELLS);
        }
    }
    return taken > 0.0;
}

// Whether a caster is so small that rays of one texel see it differently. Splats and cells of volumes always count as thin, since their
// radius does not tell how thin they are.
bool is_thin(View view, Caster caster) {
    vec2 sides = texel_sides(view, max(caster.position.z, view.near));
    return caster.radius < WIDE * max(sides.x, sides.y) || caster_is_splat_or_cell(caster);
}

// Same as view_segment, but with AREA averaged over the whole texel.
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
    if (AREA && is_thin(view, caster)) {
        bool hit = sphere_mean(view, ray, caster, dark, z, taken);
        optical_depth = taken < 0.999999 ? min(optical_depth_of(taken), dark) : dark;
        return hit;
    }
    return view_segment(view, ray, ray_length, caster, dark, z, optical_depth);
}

// Transmittance of each cell, relative to the other cells: a caster that absorbs the same fraction of light in all cells changes nothing
// here.
float cell_light[AREA_CELLS];

void area_clear() {
    [[unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
        cell_light[i] = 1.0;
    }
}

// Optical depth by which a caster lowers the texel's mean light; `optical_depth`: the result of texel_part for the caster. Casters must
// come in order, starting at the light. Their overlap is tracked per cell of the texel; within a cell it is left to chance, as in
// texel_part.
float area_seen(View view, Ray ray, Caster caster, float dark, float optical_depth) {
    if (!AREA || !(caster_is_strand(caster) || is_thin(view, caster))) {
        return optical_depth;
    }
    float taken[AREA_CELLS], deepest = 0.0;
    if (caster_is_strand(caster)) {
        strand_cells(view, ray, caster, taken);
        deepest = min(caster.density, dark);
        float whole = share_taken(deepest);
        [[unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
            taken[i] *= whole;
        }
    } else {
        [[dont_unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
            vec2 z;
            float its;
            bool hit = sphere_part(view, ray, caster, dark, i, z, its);
            deepest = hit ? max(deepest, its) : deepest;
            // Writes taken[i] by comparison instead of an index, so that the array stays in registers.
            [[unroll]] for (uint j = 0u; j < AREA_CELLS; ++j) {
                taken[j] = j != i ? taken[j] : hit ? share_taken(its) : 0.0;
            }
        }
    }
    float light = 0.0, lost = 0.0;
    [[unroll]] for (uint i = 0u; i < AREA_CELLS; ++i) {
        float its = cell_light[i] * min(taken[i], 1.0);
        light += cell_light[i];
        lost += its;
        cell_light[i] -= its;
    }
    if (!(lost > 0.0)) {
        return 0.0;  // no light is left where the caster is
    }
    float share = lost / light;
    return share < 0.999999 ? min(optical_depth_of(share), deepest) : deepest;
}
#endif
