#version 460
// Counts the occupied voxels in the cells of a level: cells of 8 voxels per side from the bits of 8 bricks, larger ones from 8 cells of the
// level below. One thread per cell. Source: after Crassin et al. 2011, section 4. Inputs: bits, the level below. Output: the level.
// Twin: reference::twin::cone::Cells.
layout(local_size_x = 64) in;
#include "grid/build.glsl"
#include "grid/cells.glsl"

// set 1: grid_cells
layout(set = 1, binding = 0, scalar) buffer CellsCounts { uint counts[]; };

void main() {
    uint i = 64u * (gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x) + gl_LocalInvocationIndex;
    uint side = grid.size >> level;
    if (i >= side * side * side) {
        return;
    }
    uvec3 cell = uvec3(i % side, i / side % side, i / (side * side));
    uint sum = 0u;
    for (uint child = 0u; child < 8u; ++child) {
        uvec3 below = 2u * cell + uvec3(child & 1u, child >> 1 & 1u, child >> 2);
        if (level == CELLS_FIRST) {
            uint word = 2u * grid_word(grid.size, 0u, 4u * below);
            sum += uint(bitCount(grid_bits[word]) + bitCount(grid_bits[word + 1u]));
        } else {
            sum += counts[cell_at(grid.size, level - 1u, below)];
        }
    }
    counts[cell_at(grid.size, level, cell)] = sum;
}
