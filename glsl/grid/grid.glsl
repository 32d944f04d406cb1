// A grid of voxels along the world's axes, around all casters. Each voxel has one bit, set if meshes occupy the voxel, in bricks of 4 × 4 ×
// 4 bits. There are two levels above: one bit per brick, and one bit per block of 64 bricks, set if the brick or block is not empty.
// Source: ours. Twins: grid::GridData, reference::twin::grid.
#ifndef GRID_GRID_GLSL
#define GRID_GRID_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Grid {
    vec3 origin;     // minimum corner, world units
    float voxel;     // side of a voxel, world units
    float per_unit;  // voxels per world unit
    uint size;       // voxels per side
    uint low[3];     // bounds of all casters, floats in the order-preserving form of maps/extents.glsl
    uint high[3];
};

const uint GRID_LEVELS = 3u;

// Number of 64-bit words per side of a level. A bit represents a voxel on level 0, a brick on level 1, and a block of 16 voxels per side on
// level 2.
uint grid_side(uint size, uint level) { return size >> (2u * level + 2u); }

// Index of a level's first word.
uint grid_level_at(uint size, uint level) {
    uint at = 0u;
    for (uint l = 0u; l < level; ++l) {
        uint side = grid_side(size, l);
        at += side * side * side;
    }
    return at;
}

// The word of a level that contains a voxel.
uint grid_word(uint size, uint level, uvec3 voxel) {
    uvec3 word = voxel >> (2u * level + 2u);
    uint side = grid_side(size, level);
    return grid_level_at(size, level) + (word.z * side + word.y) * side + word.x;
}

// Index of the voxel's bit in that word.
uint grid_bit(uint level, uvec3 voxel) {
    uvec3 bit = (voxel >> (2u * level)) & 3u;
    return bit.x | bit.y << 2 | bit.z << 4;
}
#endif
