// Marks a voxel as occupied. Twin: reference::twin::grid::Bits.
#ifndef GRID_OCCUPY_GLSL
#define GRID_OCCUPY_GLSL
#include "grid/facing.glsl"

void occupy(uvec3 voxel) {
    uint bit = grid_bit(0u, voxel), word = 2u * grid_word(grid.size, 0u, voxel) + (bit >> 5);
    uint mask = 1u << (bit & 31u);
    if ((grid_bits[word] & mask) != 0u || atomicOr(grid_bits[word], mask) != 0u) {
        return;
    }
    // The thread that sets the first bit of a word sets the bits on the levels above.
    for (uint level = 1u; level < GRID_LEVELS; ++level) {
        bit = grid_bit(level, voxel);
        word = 2u * grid_word(grid.size, level, voxel) + (bit >> 5);
        mask = 1u << (bit & 31u);
        if (atomicOr(grid_bits[word], mask) != 0u) {
            return;
        }
    }
}
#endif
