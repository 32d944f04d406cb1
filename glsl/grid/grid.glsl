// A grid of voxels along the world's axes, around all casters. One bit per voxel is set where meshes occupy it, in bricks of 4 × 4 × 4
// bits. There are two levels above: one bit per brick, and one bit per block of 64 bricks. A bit is set if its brick or block is not empty.
// Source: ours. Twins: grid::GridData, reference::twin::grid.
#ifndef GRID_GRID_GLSL
#define GRID_GRID_GLSL
#extension GL_EXT_scalar_block_layout : require

struct Grid {
    vec3 origin;     // its corner, world units
    float voxel;     // a voxel's side, world units
    float per_unit;  // voxels per world unit
    uint size;       // voxels per side
    uint low[3];     // bounds of all casters, floats as maps/extents.glsl orders them
    uint high[3];
};

const uint GRID_LEVELS = 3u;

// How many words of 64 bits there are per side of a level. A bit stands for a voxel on level 0, for a brick on level 1, and for a block of
// 16 voxels per side on level 2.
uint grid_side(uint size, uint level) { return size >> (2u * level + 2u); }

// Where a level's words begin.
uint grid_level_at(uint size, uint level) {
    uint at = 0u;
    for (uint l = 0u; l < level; ++l) {
        uint side = grid_side(size, l);
        at += side * side * side;
    }
    return at;
}

// The word of a level that a voxel is in.
uint grid_word(uint size, uint level, uvec3 voxel) {
    uvec3 word = voxel >> (2u * level + 2u);
    uint side = grid_side(size, level);
    return grid_level_at(size, level) + (word.z * side + word.y) * side + word.x;
}

// The voxel's bit in that word.
uint grid_bit(uint level, uvec3 voxel) {
    uvec3 bit = (voxel >> (2u * level)) & 3u;
    return bit.x | bit.y << 2 | bit.z << 4;
}
#endif
