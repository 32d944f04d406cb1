#version 460
// Clears the bricks that are not empty. One workgroup per block of 64 bricks. Source: ours. Input and output: bits.
// Twin: reference::twin::grid, which starts from an empty grid.
layout(local_size_x = 64) in;
#include "grid/build.glsl"

void main() {
    uint block = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, side = grid_side(grid.size, 1u);
    if (block >= side * side * side) {
        return;
    }
    uint thread = gl_LocalInvocationIndex, at = 2u * (grid_level_at(grid.size, 1u) + block);
    uint bits = grid_bits[at + (thread >> 5)];
    barrier();
    if ((bits >> (thread & 31u) & 1u) == 1u) {
        uvec3 brick = 4u * uvec3(block % side, block / side % side, block / (side * side));
        brick += uvec3(thread & 3u, thread >> 2 & 3u, thread >> 4);
        uint word = 2u * grid_word(grid.size, 0u, 4u * brick);
        grid_bits[word] = 0u;
        grid_bits[word + 1u] = 0u;
    }
    if (thread < 2u) {
        grid_bits[at + thread] = 0u;
    }
}
