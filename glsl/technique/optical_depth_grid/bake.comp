#version 460
// Bakes the optical depth from each cell's centre to each light, through a density grid. Each cell has WAY_PARTS threads, each of which
// marches a part of the ray to the light. Source: Schneider 2023 (Nubis³). Inputs: lights, the grid, its media. Output: the optical depths
// of all cells. `place`: the grid that the cells are laid out on. Twin: reference::twin::optical_depth_grid.
layout(local_size_x = 64) in;
#include "grid/media.glsl"
#include "grid/way.glsl"

layout(push_constant, scalar) uniform BakePush {
    uint first;   // first layer of cells to bake
    uint layers;
    uint lights;
};

// set 0: optical_depth_grid
layout(set = 0, binding = 0, scalar) readonly buffer BakeLights { Light lights_of[]; };
layout(set = 0, binding = 1, scalar) readonly buffer BakeGrid { Grid grid; };
layout(set = 0, binding = 2, scalar) readonly buffer BakeMedia { uint visibility_media[]; };
layout(set = 0, binding = 3, scalar) readonly buffer BakeMediaBits { uint visibility_media_bits[]; };
layout(set = 0, binding = 4, scalar) readonly buffer BakePlace { Grid place; };
layout(set = 0, binding = 5, scalar) writeonly buffer BakeDepths { float depths[]; };

// Voxels per side of the density grid, and cells per side.
CONSTANT(uint, GRID_SIZE, 64u)
CONSTANT(uint, CELLS, 64u)

// Number of threads per cell, each of which marches an equal part of the cell's ray: 1, 2, 4 or 8.
CONSTANT(uint, WAY_PARTS, 1u)

// Optical depth of each thread's part.
shared float taken[64];

// Voxels absorb the same in every direction.
float media_towards(float sum, uvec3 voxel) { return sum; }

#include "grid/march_media.glsl"

// Returns the optical depth of a thread's part of a cell's ray.
float part_of(uvec3 cell, uint light, uint part) {
    float side = place.voxel * (float(GRID_SIZE) / float(CELLS));
    vec3 from, way;
    if (!grid_way(grid, lights_of[light], place.origin + (vec3(cell) + 0.5) * side, from, way)) {
        return 0.0;
    }
    vec2 range = grid_clip(from, way, GRID_SIZE);
    if (WAY_PARTS == 1u || range.x > range.y) {
        return media_exact(from, way);
    }
    vec2 ends = mix(range.xx, range.yy, vec2(part, part + 1u) / float(WAY_PARTS));
    return media_exact(from + ends.x * way, (ends.y - ends.x) * way);
}

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, in_group = 64u / WAY_PARTS;
    uint thread = gl_LocalInvocationIndex, part = thread / in_group;
    uint i = in_group * group + thread % in_group, each = CELLS * CELLS * layers, light = i / each, at = i % each;
    uvec3 cell = uvec3(at % CELLS, at / CELLS % CELLS, first + at / (CELLS * CELLS));
    taken[thread] = light < lights ? part_of(cell, light, part) : 0.0;
    barrier();
    if (part > 0u || light >= lights) {
        return;
    }
    float sum = taken[thread];
    for (uint other = 1u; other < WAY_PARTS; ++other) {
        sum += taken[thread + in_group * other];
    }
    depths[((light * CELLS + cell.z) * CELLS + cell.y) * CELLS + cell.x] = min(sum, MEDIA_DARK);
}
