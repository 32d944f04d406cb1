#version 460
// Finds the greatest number that the media (smoke and hair) have in any voxel. One workgroup per block of 64 bricks. Source: none. Inputs:
// media, their bits. Output: the greatest number. Twin: the greatest of reference::twin::media::Media.
layout(local_size_x = 64) in;
#include "grid/cast.glsl"

// set 2: grid_most
layout(set = 2, binding = 0, scalar) buffer CastMost { uint most; };

void main() {
    uint block = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, side = grid_side(grid.size, 1u);
    if (block >= side * side * side) {
        return;
    }
    uint thread = gl_LocalInvocationIndex, at = 2u * (grid_level_at(grid.size, 1u) + block), greatest = 0u;
    uvec3 first = 4u * uvec3(block % side, block / side % side, block / (side * side));
    for (uint b = 0u; b < 64u; ++b) {
        if ((media_bits[at + (b >> 5)] >> (b & 31u) & 1u) == 1u) {
            uint word = grid_word(grid.size, 0u, 4u * (first + uvec3(b & 3u, b >> 2 & 3u, b >> 4)));
            bool full = (media_bits[2u * word + (thread >> 5)] >> (thread & 31u) & 1u) == 1u;
            greatest = max(greatest, full ? 0xFFFFFFFFu : media[64u * word + thread]);
        }
    }
    if (greatest > 0u) {
        atomicMax(most, greatest);
    }
}
