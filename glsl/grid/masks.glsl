// Masks: 4 × 4 × 4 cells of an occupied voxel, a bit each in the order of a brick's voxels. First how many occupied voxels stand before each
// brick, then a word of 64 bits for each of them, in the order of bricks and in each of its bits. Source: ours.
// Twin: reference::twin::masks::Masks.
#ifndef GRID_MASKS_GLSL
#define GRID_MASKS_GLSL
#include "grid/grid.glsl"

// What a grid's shadows are of: CELL is one of these.
const uint CELL_SOLID = 0u;
const uint CELL_MASK = 1u;
const uint CELL_TRIANGLES = 2u;

// Cells a voxel's side: two to the power of this.
const uint MASK_SHIFT = 2u;

// Where the first half of a voxel's mask stands: `before` is its brick's number, `brick` the brick's bits, `bit` the voxel's of them.
uint mask_word(uint size, uint before, uvec2 brick, uint bit) {
    uint low = bit < 32u ? (1u << bit) - 1u : ~0u, high = bit < 32u ? 0u : (1u << (bit - 32u)) - 1u;
    return grid_level_at(size, 1u) + 2u * (before + uint(bitCount(brick.x & low) + bitCount(brick.y & high)));
}
#endif
