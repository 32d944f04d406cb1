// Masks: 4 × 4 × 4 cells of an occupied voxel, one bit each, in the order of a brick's voxels. First there is one word per brick, the
// number of occupied voxels before it. Then follow 64 bits per occupied voxel, in the order of bricks and of the bits in each brick.
// Source: ours. Twin: reference::twin::masks::Masks.
#ifndef GRID_MASKS_GLSL
#define GRID_MASKS_GLSL
#include "grid/grid.glsl"

// What casts shadows in a grid: its voxels, the cells of their masks, or the triangles themselves. Values of CELL.
const uint CELL_SOLID = 0u;
const uint CELL_MASK = 1u;
const uint CELL_TRIANGLES = 2u;

// log2 of the number of cells per side of a voxel.
const uint MASK_SHIFT = 2u;

// Word of the first half of a voxel's mask. `before`: number of occupied voxels before its brick; `brick`: the brick's bits; `bit`: the
// voxel's bit among these.
uint mask_word(uint size, uint before, uvec2 brick, uint bit) {
    uint low = bit < 32u ? (1u << bit) - 1u : ~0u, high = bit < 32u ? 0u : (1u << (bit - 32u)) - 1u;
    return grid_level_at(size, 1u) + 2u * (before + uint(bitCount(brick.x & low) + bitCount(brick.y & high)));
}
#endif
