#version 460
// Clears the bricks of media that are not empty. One workgroup per block of 64 bricks. Source: ours. Input and output: media, their bits.
// Twin: reference::twin::media, which starts from an empty grid.
layout(local_size_x = 64) in;
#include "grid/cast.glsl"

void main() {
    uint block = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x, side = grid_side(grid.size, 1u);
    if (block >= side * side * side) {
        return;
    }
    uint thread = gl_LocalInvocationIndex, at = 2u * (grid_level_at(grid.size, 1u) + block);
    uvec2 bits = uvec2(media_bits[at], media_bits[at + 1u]);
    barrier();
    uvec3 first = 4u * uvec3(block % side, block / side % side, block / (side * side));
    for (uint b = 0u; b < 64u && any(notEqual(bits, uvec2(0u))); ++b) {
        if ((bits[b >> 5] >> (b & 31u) & 1u) == 0u) {
            continue;
        }
        uint word = grid_word(grid.size, 0u, 4u * (first + uvec3(b & 3u, b >> 2 & 3u, b >> 4)));
        media[64u * word + thread] = 0u;
        if (thread < 2u) {
            media_bits[2u * word + thread] = 0u;
        }
    }
    if (thread < 2u) {
        media_bits[at + thread] = 0u;
    }
}
