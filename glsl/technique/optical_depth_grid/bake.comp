#version 460
// The optical depth from each cell's middle to each light, through a density grid. One thread a cell. Source: Schneider 2023 (Nubis³).
// Inputs: lights, the grid, its media. Output: depths, of cells that stand where `place` says. Twin: reference::twin::optical_depth_grid.
layout(local_size_x = 64) in;
#include "grid/media.glsl"
#include "grid/way.glsl"

layout(push_constant, scalar) uniform BakePush {
    uint first;   // of the layers of cells that are baked
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

// Voxels a side of the density grid, and cells.
CONSTANT(uint, GRID_SIZE, 64u)
CONSTANT(uint, CELLS, 64u)

// Voxels take the same in each direction.
float media_towards(float sum, uvec3 voxel) { return sum; }

#include "grid/march_media.glsl"

void main() {
    uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
    uint i = 64u * group + gl_LocalInvocationIndex, each = CELLS * CELLS * layers, light = i / each, at = i % each;
    if (light >= lights) {
        return;
    }
    uvec3 cell = uvec3(at % CELLS, at / CELLS % CELLS, first + at / (CELLS * CELLS));
    float side = place.voxel * (float(GRID_SIZE) / float(CELLS));
    vec3 from, way;
    bool known = grid_way(grid, lights_of[light], place.origin + (vec3(cell) + 0.5) * side, from, way);
    depths[((light * CELLS + cell.z) * CELLS + cell.y) * CELLS + cell.x] = known ? media_exact(from, way) : 0.0;
}
