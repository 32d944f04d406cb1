// Where the triangles of a voxel are listed. First a word per brick: where the starts of its used voxels begin. Then two words per used voxel, in the
// order of the bits: where its list starts, and the box about all that is listed (glsl/grid/lists/box.glsl). Then where the last list ends. Then the
// lists, two words per triangle: its box in the voxel, and its number. All places are words from the beginning, so that bricks, the bits of one and two
// starts lead to a list. Behind all bricks is one more, whose one voxel is always used: it lists what is in too many voxels to be listed in each, for
// every ray to ask. Source: ours. Twin: reference::twin::lists.
#ifndef GRID_LISTS_PLACE_GLSL
#define GRID_LISTS_PLACE_GLSL
#include "grid/grid.glsl"

// The number of the brick whose list all voxels share, in a grid of so many voxels per side.
uint lists_of_all(uint size) {
    uint side = grid_side(size, 0u);
    return side * side * side;
}

// Words of a used voxel, and of an entry of a list.
const uint LIST_WORDS = 2u;

// How many voxels of a brick are used before that of bit `bit`.
uint used_before(uvec2 bits, uint bit) {
    uint below = (1u << (bit & 31u)) - 1u;
    return bit < 32u ? uint(bitCount(bits.x & below)) : uint(bitCount(bits.x) + bitCount(bits.y & below));
}
#endif
