// Marks a cell of a voxel's mask as occupied. Twin: reference::twin::masks::Masks.
#ifndef GRID_OCCUPY_CELL_GLSL
#define GRID_OCCUPY_CELL_GLSL
#define FACET_CELLS 4
#include "grid/facing.glsl"
#include "grid/masks_set.glsl"

void occupy(uvec3 cell) {
    uvec3 voxel = cell >> MASK_SHIFT;
    uint brick = grid_word(grid.size, 0u, voxel), bit = grid_bit(0u, voxel);
    uvec2 voxels = uvec2(grid_bits[2u * brick], grid_bits[2u * brick + 1u]);
    // Rounding may put a cell into a voxel that is not occupied and has no mask: such a cell is skipped. Masks beyond the buffer's capacity
    // are skipped until the host enlarges the buffer.
    if ((voxels[bit >> 5] >> (bit & 31u) & 1u) == 0u) {
        return;
    }
    uint word = mask_word(grid.size, masks[brick], voxels, bit), at = grid_bit(0u, cell);
    word += at >> 5;
    uint mask = 1u << (at & 31u);
    if (word < uint(masks.length()) && (masks[word] & mask) == 0u) {
        atomicOr(masks[word], mask);
    }
}
#endif
