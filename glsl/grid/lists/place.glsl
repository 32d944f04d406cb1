// Layout of the voxels' lists of triangles, in words. First one word per brick: where the entries of its used voxels begin. Then an entry
// of two words per used voxel, in the order of the bits: where its list starts, and the box around everything that it lists
// (glsl/grid/lists/box.glsl). Then one word for the end of the last list. Then the lists, two words per triangle: its box in the voxel, and
// its index. All positions are in words from the beginning. So a brick's word and bits lead to a voxel's entry, and two starts to its list.
// After all bricks there is one extra brick with one voxel, which is always used. That voxel lists the casters that overlap too many voxels
// to be listed in each of them. Every ray tests these casters. Source: ours. Twin: reference::twin::lists.
#ifndef GRID_LISTS_PLACE_GLSL
#define GRID_LISTS_PLACE_GLSL
#include "grid/grid.glsl"

// Index of the brick whose list all voxels share, in a grid of `size` voxels per side.
uint lists_of_all(uint size) {
    uint side = grid_side(size, 0u);
    return side * side * side;
}

// Number of words per used voxel, and per entry of a list.
const uint LIST_WORDS = 2u;

// Number of used voxels in a brick before the voxel of bit `bit`.
uint used_before(uvec2 bits, uint bit) {
    uint below = (1u << (bit & 31u)) - 1u;
    return bit < 32u ? uint(bitCount(bits.x & below)) : uint(bitCount(bits.x) + bitCount(bits.y & below));
}
#endif
