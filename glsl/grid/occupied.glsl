// One bit per voxel: whether a mesh occupies it. Needs visibility_bits and the constant GRID_SIZE.
#ifndef GRID_OCCUPIED_GLSL
#define GRID_OCCUPIED_GLSL
#include "grid/grid.glsl"

// The 64 bits of a level's word.
uvec2 grid_bits(uint level, uvec3 word) {
    uint side = grid_side(GRID_SIZE, level);
    uint at = 2u * (grid_level_at(GRID_SIZE, level) + (word.z * side + word.y) * side + word.x);
    return uvec2(visibility_bits[at], visibility_bits[at + 1u]);
}
#endif
