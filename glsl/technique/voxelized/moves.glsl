// Data that a bake keeps for the next bake while something moves: where the shadow of each column of each tile begins, the range of each
// block of columns, and a mark for each block whose columns must be computed again. For a block without a mark, the data are the same as
// after a full bake. Twin: none; a partial bake has the same words as a full one.
#ifndef TECHNIQUE_VOXELIZED_MOVES_GLSL
#define TECHNIQUE_VOXELIZED_MOVES_GLSL

// Words of a tile per block: one for each of its columns, two for its range, one for its mark.
const uint TILE_WORDS = 67u;

uint range_at(uint block) { return columns_at + 64u * width * width + 2u * block; }

uint mark_at(uint block) { return columns_at + 66u * width * width + block; }

// Returns whether the columns of a block of the tile must be computed.
bool block_moves(uint block) { return (mode & WHOLE) != 0u || moves_wide != 0u || boundaries[mark_at(block)] != 0u; }
#endif
