// Optical depth grid look-up: how much of light `light` reaches `position`, 0 to 1, from the baked optical depth, interpolated linearly
// between the cells' centres. A point outside the grid gets the optical depth at the place where its ray to the light enters the grid.
// Meshes cast shadows through the light's opaque map. Source: Schneider 2023 (Nubis³). Twin: reference::twin::optical_depth_grid.
//
//   binding 0  lights (world/light.glsl)
//   binding 1  the grid that the cells are laid out on (grid/grid.glsl)
//   binding 2  optical depths of the cells, light by light, layers of rows
//   binding 3  maps of all lights (world/light.glsl)
//   binding 4  the opaque map (maps/look_up_set.glsl, binding 2)
// flat: bindings 184, constants 368: GRID_SIZE CELLS NORMAL_BIAS
#include "grid/walk.glsl"
#include "grid/way.glsl"

#ifndef GOBO_SET
#define GOBO_SET 1
#endif

layout(set = GOBO_SET, binding = 0, scalar) readonly buffer VisibilityLights { Light visibility_lights[]; };
layout(set = GOBO_SET, binding = 1, scalar) readonly buffer VisibilityPlace { Grid visibility_place; };
layout(set = GOBO_SET, binding = 2, scalar) readonly buffer VisibilityDepths { float visibility_depths[]; };
layout(set = GOBO_SET, binding = 3, scalar) readonly buffer VisibilityMaps { Map visibility_maps[]; };
layout(set = GOBO_SET, binding = 4) uniform sampler2D visibility_opaque;

#include "grid/meshes.glsl"

// Voxels per side of the grid that the optical depths were baked from.
CONSTANT(uint, GRID_SIZE, 64u)
// Cells per side.
CONSTANT(uint, CELLS, 64u)

// Returns the baked optical depth at a place, interpolated linearly between the centres of eight cells.
float baked_depth(uint light, vec3 place) {
    vec3 at = clamp(place - 0.5, vec3(0.0), vec3(CELLS - 1u));
    uvec3 corner = min(uvec3(at), uvec3(CELLS - 2u));
    vec3 share = at - vec3(corner);
    float sum = 0.0;
    for (uint i = 0u; i < 8u; ++i) {
        uvec3 high = uvec3(i & 1u, i >> 1 & 1u, i >> 2), cell = corner + high;
        vec3 weights = mix(1.0 - share, share, equal(high, uvec3(1u)));
        sum += weights.x * weights.y * weights.z *
               visibility_depths[((light * CELLS + cell.z) * CELLS + cell.y) * CELLS + cell.x];
    }
    return sum;
}

float light_visibility(uint light, vec3 position) {
    float left = meshes_leave(light, position);
    vec3 from, way;
    if (left == 0.0 || !grid_way(visibility_place, visibility_lights[light], position, from, way)) {
        return left;
    }
    vec2 range = grid_clip(from, way, GRID_SIZE);
    if (range.x > range.y) {
        return left;
    }
    return left * exp(-baked_depth(light, (from + way * range.x) * (float(CELLS) / float(GRID_SIZE))));
}
