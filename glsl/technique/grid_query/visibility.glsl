// Grid query look-up: how much of light `light` reaches `position`, past all casters and triangles along the ray. Each is tested
// individually, so that the result is exact up to rounding; the grid only selects the casters and triangles to test. Source: ours; the
// march follows Amanatides and Woo 1987, the triangle test Woop et al. 2013.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  the grid (grid/grid.glsl)
//   binding 2  the grid's bits for meshes
//   binding 3  the grid's lists of triangles (grid/lists/place.glsl)
//   binding 4  triangles (world/triangle_rows.glsl)
//   binding 5  the grid's bits for smoke and hair
//   binding 6  the grid's lists of casters (grid/lists/place.glsl)
//   binding 7  casters (world/caster.glsl)
// flat: bindings 168, constants 336: GRID_SIZE STRANDS SPLATS_OR_CELLS ALPHA_FIRST SHEETS
#include "world/colors.glsl"
#include "world/caster.glsl"
#include "world/light.glsl"
#include "grid/grid.glsl"
#include "world/triangle_rows.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityGrid { Grid visibility_grid; };
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityBits { uint visibility_bits[]; };
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityCells { uint visibility_cells[]; };
layout(set = GOBO_SET, binding = 4, scalar) readonly buffer VisibilityTriangles { TriangleRows visibility_triangles[]; };
layout(set = GOBO_SET, binding = 5, scalar) readonly buffer VisibilityCastBits { uint visibility_cast_bits[]; };
layout(set = GOBO_SET, binding = 6, scalar) readonly buffer VisibilityCastLists { uint visibility_cast_lists[]; };
layout(set = GOBO_SET, binding = 7, scalar) readonly buffer VisibilityCasters { Caster visibility_casters[]; };

// Voxels per side.
CONSTANT(uint, GRID_SIZE, 64u)

#include "grid/march_casters.glsl"
#include "grid/march_triangles.glsl"
#include "world/sheet.glsl"

// Returns where a ray to a light ends. A virtual light sits on a surface; the end is moved off that surface, so that the surface blocks no
// ray, however the end is rounded.
vec3 light_end(Light l) {
    if (l.kind != LIGHT_VIRTUAL) {
        return l.position;
    }
    float reach = abs(l.direction.x) + abs(l.direction.y) + abs(l.direction.z);
    return l.position + l.direction * (reach * grid_rounding(visibility_grid));
}

float light_visibility(uint light, vec3 position) {
    look_up_meshes = 1.0;
    Light l = visibility_lights[light];
    vec3 from = (position - visibility_grid.origin) * visibility_grid.per_unit;
    // NaN has no voxel.
    if (!(all(lessThan(abs(from), vec3(1e7))))) {
        return 1.0;
    }
    float size = float(GRID_SIZE);
    // Long enough to leave the grid in any direction.
    float far = (2.0 * size + distance(from, vec3(0.5 * size))) * visibility_grid.voxel;
    vec3 direction = l.kind == LIGHT_DIRECTIONAL ? -l.direction * far : light_end(l) - position;
    vec3 way = direction * visibility_grid.per_unit;
    if (march_triangles(from, way, position, direction, 1.0)) {
        look_up_meshes = 0.0;
        return 0.0;
    }
    return exp(-march_casters(from, way, Ray(position, direction)));
}
