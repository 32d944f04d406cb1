// What a bake keeps for the next bake while something moves. It keeps where each column of each tile begins to be in shadow, the range of
// each block of columns, and a mark for each block whose columns must be found anew. For a block without a mark, the bake holds the same as
// a whole bake would. Twin: none; a bake by parts has the words of a whole one.
#ifndef TECHNIQUE_VOXELIZED_MOVES_GLSL
#define TECHNIQUE_VOXELIZED_MOVES_GLSL

// Words of a tile for each block: its columns, two of its range, its mark.
const uint TILE_WORDS = 67u;

uint range_at(uint block) { return columns_at + 64u * width * width + 2u * block; }

uint mark_at(uint block) { return columns_at + 66u * width * width + block; }

// Whether the columns of a block of the tile are to be found.
bool block_moves(uint block) { return (mode & WHOLE) != 0u || moves_wide != 0u || boundaries[mark_at(block)] != 0u; }
#endif
