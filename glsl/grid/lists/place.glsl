// How the list of each voxel's triangles is stored, in words. First a word per brick: where the entries of its used voxels begin. Then an
// entry of two words per used voxel, in the order of the bits: where its list starts, and the box around all that is listed
// (glsl/grid/lists/box.glsl). Then a word that says where the last list ends. Then the lists, two words per triangle: its box in the voxel,
// and its number. All places are counted in words from the beginning. So a brick's word and bits lead to a voxel's entry, and two starts to
// its list. Behind all bricks is one extra brick with one voxel, which is always used. That voxel lists the casters that lie in too many
// voxels to be listed in each of them. Every ray tests these casters. Source: ours. Twin: reference::twin::lists.
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
